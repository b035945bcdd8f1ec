#define TINYGLTF_IMPLEMENTATION
#include "scene/document/tinygltf.h"
