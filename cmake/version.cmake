# SPDX-License-Identifier: Apache-2.0
# Writes generated/version.h: the version, and the commit with "-dirty" where tracked files differ from it.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit "unknown")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once
#define SINEW_VERSION \"${VERSION}\"
#define SINEW_COMMIT \"${commit}\"
")
