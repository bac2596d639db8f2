// SPDX-License-Identifier: Apache-2.0
// Types of the binary interface of FMI 2.0 ("Functional Mock-up Interface for Model Exchange and Co-Simulation", version 2.0.4, sections
// 2.1.1 to 2.1.5 and 4.2.1), as a 64-bit Linux has them: `typesPlatform` is "default". Names, order and sizes are the standard's.
#pragma once

#include <cstddef>

extern "C" {

using fmi2Component = void*;
using fmi2ComponentEnvironment = void*;
using fmi2FMUstate = void*;
using fmi2ValueReference = unsigned int;
using fmi2Real = double;
using fmi2Integer = int;
using fmi2Boolean = int;  // 0 or 1
using fmi2Byte = char;
using fmi2String = const char*;

enum fmi2Status { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending };
enum fmi2Type { fmi2ModelExchange, fmi2CoSimulation };
enum fmi2StatusKind { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated };

// What the importing program offers. `logger` formats its last arguments as printf does.
struct fmi2CallbackFunctions {
  void (*logger)(fmi2ComponentEnvironment, fmi2String instance_name, fmi2Status, fmi2String category, fmi2String message, ...);
  void* (*allocateMemory)(std::size_t count, std::size_t size);
  void (*freeMemory)(void*);
  void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
  fmi2ComponentEnvironment componentEnvironment;
};
}
