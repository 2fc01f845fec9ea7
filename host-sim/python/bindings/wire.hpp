#pragma once

#include "host-sim/python/bindings/bindings.hpp"
#include "model/files/wire/wire_file.hpp"
#include "model/wire/plant.hpp"
