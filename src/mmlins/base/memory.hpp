// SPDX-License-Identifier: MIT
#pragma once
// What the allocator keeps for later.

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

namespace mmlins {

/// Gives memory that was freed back to the system, which the allocator does not do by itself where small
/// pieces in use lie in between. Takes milliseconds: for moments at which much was freed.
inline void return_freed_memory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace mmlins
