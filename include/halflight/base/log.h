#pragma once
// Logging: spdlog's default logger, on standard error. The library logs only what no return value carries.
#include <spdlog/spdlog.h>
