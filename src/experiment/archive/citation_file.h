/* CITATION.cff of the sources, which the build makes a part of the program. */
#pragma once

extern const char ll_citation[];
