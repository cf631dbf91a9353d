// What toml++ compiles once instead of in every file that reads TOML.
#define TOML_IMPLEMENTATION
#include "drivers/recording/toml_library.hpp"
