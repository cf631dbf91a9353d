#include "drivers/measurement/clock_model.hpp"
