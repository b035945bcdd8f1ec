#pragma once
// What JSON type each member has that the scene module reads: one table, checked before anything is read.

#include "scene/document/document.h"

namespace halflight {

/// The first member whose JSON type is not the one that glTF 2.0 (or the extension's text) gives it is an error with
/// its path. `null` is a type of its own: no member may be null. Numbers must fit floats, indices 31 bits, lengths 32.
/// Members that nobody reads (extras, unknown extensions) may hold anything, but each "extensions" holds objects by
/// name.
Status checkTypes(const Json& document);

} // namespace halflight
