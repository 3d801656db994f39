#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws a run from above: its map, coloured by height, and its trajectory. Needs numpy and matplotlib.

    tools/plot_run.py RUN_FOLDER OUT.png
"""
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def read_map(path):
    with open(path, "rb") as file:
        for line in file:
            if line.startswith(b"DATA"):
                break
        return np.frombuffer(file.read(), dtype="<f4").reshape(-1, 4)


def main():
    folder, out = sys.argv[1:]
    points = read_map(f"{folder}/map.pcd")
    way = np.loadtxt(f"{folder}/trajectory.tum")[:, 1:4]
    figure, axes = plt.subplots(figsize=(9, 5.2), dpi=110, facecolor="#101418")
    axes.set_facecolor("#101418")
    low, high = np.percentile(points[:, 2], [2, 98])
    order = np.argsort(points[:, 2])
    axes.scatter(points[order, 0], points[order, 1], c=points[order, 2], s=0.05, cmap="viridis", vmin=low, vmax=high,
                 linewidths=0, rasterized=True)
    axes.plot(way[:, 0], way[:, 1], color="#ff7043", linewidth=1.4)
    axes.set_aspect("equal")
    axes.axis("off")
    figure.tight_layout(pad=0.1)
    figure.savefig(out)


if __name__ == "__main__":
    main()
