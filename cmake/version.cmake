# SPDX-License-Identifier: Apache-2.0
# Writes generated/version.h: the version, the commit with "-dirty" where tracked files differ from it, and a hash of what computes a
# result that is kept: the sources of plant, sim and model, and how they are compiled. A commit that changes none of them keeps it.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit "unknown")
endif()
set(content "${HOW}")
foreach(room plant sim model)
  file(GLOB_RECURSE files RELATIVE ${SOURCE} ${SOURCE}/${room}/*.h ${SOURCE}/${room}/*.cpp)
  list(SORT files)
  foreach(file IN LISTS files)
    file(SHA256 ${SOURCE}/${file} hash)
    string(APPEND content ";${file} ${hash}")
  endforeach()
endforeach()
string(SHA256 code "${content}")
string(SUBSTRING "${code}" 0 16 code)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once
#define SINEW_VERSION \"${VERSION}\"
#define SINEW_COMMIT \"${commit}\"
#define SINEW_CODE \"${code}\"
")
