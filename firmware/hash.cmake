# SPDX-License-Identifier: Apache-2.0
# Writes firmware_hash.h: the first 32 bits of the SHA-256 over all that the firmware is made of. Host and firmware both
# compile it in, and a device with another is not armed.
string(REPLACE "|" ";" FILES "${FILES}")
set(all "")
foreach(file ${FILES})
  file(SHA256 ${file} one)
  string(APPEND all ${one})
endforeach()
string(SHA256 hash "${all}")
string(SUBSTRING ${hash} 0 8 hash)
set(text "#define SINEW_FIRMWARE_HASH 0x${hash}ul\n")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} before)
endif()
if(NOT "${text}" STREQUAL "${before}")
  file(WRITE ${OUTPUT} "${text}")
endif()
