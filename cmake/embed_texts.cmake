# Puts the texts of config/<folder>/*.yaml into the given target, so that programs need no data folder:
# writes a .cpp that defines std::vector<NamedText> mmlins::sim::<function>(). The file is made anew whenever
# one of the texts changes.
function(embed_texts target folder function)
  file(GLOB files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/config/${folder}/*.yaml)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
  set(entries "")
  foreach(path ${files})
    get_filename_component(name "${path}" NAME_WE)
    file(READ "${path}" text)
    string(APPEND entries "      {\"${name}\", R\"yaml(${text})yaml\"},\n")
  endforeach()
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp)
  file(CONFIGURE OUTPUT ${output} @ONLY CONTENT "// Generated from config/${folder}/*.yaml.
#include <vector>

#include \"mmlins/sim/named_text.hpp\"

namespace mmlins::sim {

std::vector<NamedText> @function@();
std::vector<NamedText> @function@() {
  return {
@entries@  };
}

}  // namespace mmlins::sim
")
  target_sources(${target} PRIVATE ${output})
endfunction()
