# SPDX-License-Identifier: Apache-2.0
# Scripts and style of pages as C++: cmake -DSCRIPT=page.js -DLIVE=live.js -DSTYLE=page.css -DOUTPUT=page_assets.cpp -P embed.cmake
# What stands above a file's first blank line, its licence and what it is, is not embedded.
function(embed file delimiter result)
  file(READ ${file} text)
  string(FIND "${text}" "\n\n" blank)
  math(EXPR blank "${blank} + 1")
  string(SUBSTRING "${text}" ${blank} -1 text)
  string(FIND "${text}" ")${delimiter}\"" ends)
  if(NOT ends EQUAL -1)
    message(FATAL_ERROR "${file} holds )${delimiter}\", which ends a string in C++")
  endif()
  set(${result} "R\"${delimiter}(${text})${delimiter}\"" PARENT_SCOPE)
endfunction()
embed(${SCRIPT} js script)
embed(${LIVE} js live)
embed(${STYLE} css style)
file(WRITE ${OUTPUT} "#include \"report/page_assets.h\"

namespace sinew::report {

const std::string_view page_style = ${style};

const std::string_view page_script = ${script};

const std::string_view live_script = ${live};

}  // namespace sinew::report
")
