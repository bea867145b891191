#pragma once

#include "rigid/engine.h"

extern const engine laglab_engine;
