#include "ocio_shim.h"

#include <OpenColorIO/OpenColorIO.h>

namespace OCIO = OCIO_NAMESPACE;

extern "C" const char *sundog_ocio_version(void) { return OCIO::GetVersion(); }
