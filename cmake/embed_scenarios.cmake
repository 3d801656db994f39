# Puts the texts of config/scenarios/*.yaml into the given target, so that programs need no data folder:
# writes a .cpp that defines mmlins::sim::scenario_texts() (src/mmlins/sim/scenario.hpp). The file is made
# anew whenever one of the texts changes.
function(embed_scenarios target)
  file(GLOB files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/config/scenarios/*.yaml)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
  set(entries "")
  foreach(path ${files})
    get_filename_component(name "${path}" NAME_WE)
    file(READ "${path}" text)
    string(APPEND entries "      {\"${name}\", R\"yaml(${text})yaml\"},\n")
  endforeach()
  set(output ${CMAKE_CURRENT_BINARY_DIR}/scenario_texts.cpp)
  file(CONFIGURE OUTPUT ${output} @ONLY CONTENT "// Generated from config/scenarios/*.yaml.
#include \"mmlins/sim/scenario.hpp\"

namespace mmlins::sim {

std::vector<ScenarioText> scenario_texts() {
  return {
@entries@  };
}

}  // namespace mmlins::sim
")
  target_sources(${target} PRIVATE ${output})
endfunction()
