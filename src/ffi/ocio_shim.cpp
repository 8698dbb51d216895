// The C++ side of ocio_shim.h, where the rules are.

#include "ocio_shim.h"

#include <OpenColorIO/OpenColorIO.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

namespace OCIO = OCIO_NAMESPACE;

struct SundogOcioConfig {
    OCIO::ConstConfigRcPtr config;
};

struct SundogOcioProcessor {
    OCIO::ConstCPUProcessorRcPtr cpu;
};

namespace {

char *copy_or_null(const char *text) noexcept
{
    if (text == nullptr) {
        text = "";
    }
    const size_t size = std::strlen(text) + 1;
    char *copy = static_cast<char *>(std::malloc(size));
    if (copy != nullptr) {
        std::memcpy(copy, text, size);
    }
    return copy;
}

char *copy(const char *text)
{
    char *made = copy_or_null(text);
    if (made == nullptr) {
        throw std::bad_alloc();
    }
    return made;
}

void put_error(char **error, const char *text) noexcept
{
    if (error != nullptr) {
        *error = copy_or_null(text);
    }
}

// Runs `work`, which may throw; turns what it throws into a text. Sets *error to NULL first, so that a caller can
// always look at it.
template <typename Work>
bool guarded(char **error, Work &&work) noexcept
{
    if (error != nullptr) {
        *error = nullptr;
    }
    try {
        work();
        return true;
    } catch (const std::exception &thrown) {
        put_error(error, thrown.what());
    } catch (...) {
        put_error(error, "an exception that is not a std::exception");
    }
    return false;
}

// What OpenColorIO logs. A configuration can be broken in many places: what is kept has a limit.
constexpr size_t log_limit = 64 * 1024;
std::mutex log_mutex;
std::string *log_text = nullptr;

void keep_log(const char *message)
{
    if (message == nullptr) {
        return;
    }
    try {
        const std::lock_guard<std::mutex> lock(log_mutex);
        if (log_text == nullptr) {
            // Never freed: OpenColorIO's own statics may still log while the process ends.
            log_text = new std::string;
        }
        const size_t length = std::strlen(message);
        if (log_text->size() + length <= log_limit) {
            log_text->append(message, length);
            if (length == 0 || message[length - 1] != '\n') {
                log_text->push_back('\n');
            }
        }
    } catch (...) {
        // No memory for a warning: it is dropped, the work goes on.
    }
}

void catch_log()
{
    static std::once_flag once;
    std::call_once(once, [] { OCIO::SetLoggingFunction(keep_log); });
}

template <typename Make>
SundogOcioConfig *make_config(char **error, Make &&make) noexcept
{
    SundogOcioConfig *made = nullptr;
    guarded(error, [&] {
        catch_log();
        OCIO::ConstConfigRcPtr config = make();
        if (!config) {
            throw std::runtime_error("OpenColorIO made no configuration");
        }
        made = new SundogOcioConfig{std::move(config)};
    });
    return made;
}

// Refuses tables of one value a side, of which a damaged file may be: OpenColorIO 2.6 inverts those for ever, as
// InvLut3DRenderer::extrapolate3DArray counts down from their side less two.
void refuse_tables_of_one_value(const OCIO::GroupTransform &group)
{
    for (int i = 0; i < group.getNumTransforms(); ++i) {
        const OCIO::ConstTransformRcPtr part = group.getTransform(i);
        const auto *table = dynamic_cast<const OCIO::Lut3DTransform *>(part.get());
        if (table != nullptr && table->getGridSize() < 2) {
            throw std::runtime_error("a table of colours in three dimensions has one value a side, and needs two at least");
        }
        if (const auto *inner = dynamic_cast<const OCIO::GroupTransform *>(part.get())) {
            refuse_tables_of_one_value(*inner);
        }
    }
}

template <typename Make>
SundogOcioProcessor *make_processor(char **error, Make &&make) noexcept
{
    SundogOcioProcessor *made = nullptr;
    guarded(error, [&] {
        OCIO::ConstProcessorRcPtr processor = make();
        refuse_tables_of_one_value(*processor->createGroupTransform());
        made = new SundogOcioProcessor{processor->getDefaultCPUProcessor()};
    });
    return made;
}

int to_index(size_t index, int count)
{
    if (count < 0 || index >= static_cast<size_t>(count)) {
        throw std::out_of_range("the index is beyond the end of the list");
    }
    return static_cast<int>(index);
}

size_t to_count(int count)
{
    return count < 0 ? 0 : static_cast<size_t>(count);
}

OCIO::TransformRcPtr scale_by(double factor)
{
    const double scale[4] = {factor, factor, factor, 1.0};
    double matrix[16] = {};
    double offset[4] = {};
    OCIO::MatrixTransform::Scale(matrix, offset, scale);
    const OCIO::MatrixTransformRcPtr transform = OCIO::MatrixTransform::Create();
    transform->setMatrix(matrix);
    transform->setOffset(offset);
    return transform;
}

OCIO::TransformRcPtr convert(const char *source, const char *destination)
{
    const OCIO::ColorSpaceTransformRcPtr transform = OCIO::ColorSpaceTransform::Create();
    transform->setSrc(source);
    transform->setDst(destination);
    return transform;
}

// Adds the files of a transform, with a line break behind each.
void add_files(const OCIO::ConstTransformRcPtr &transform, const OCIO::ConstContextRcPtr &context, std::string &paths)
{
    if (!transform) {
        return;
    }
    if (const auto file = OCIO_DYNAMIC_POINTER_CAST<const OCIO::FileTransform>(transform)) {
        try {
            const char *path = context->resolveFileLocation(file->getSrc());
            paths += path == nullptr ? "" : path;
            paths += '\n';
        } catch (const OCIO::Exception &) {
            // It is not there: an error only where it is used.
        }
    } else if (const auto group = OCIO_DYNAMIC_POINTER_CAST<const OCIO::GroupTransform>(transform)) {
        for (int i = 0; i < group->getNumTransforms(); ++i) {
            add_files(group->getTransform(i), context, paths);
        }
    }
}

// How OpenColorIO's built-in configurations call the space that Sundog computes in.
constexpr const char *builtin_linear_rec709 = "Linear Rec.709 (sRGB)";

} // namespace

bool sundog_ocio_abi(SundogOcioAbi *abi, size_t struct_size)
{
    if (abi == nullptr || struct_size != sizeof(SundogOcioAbi)) {
        return false;
    }
    abi->abi_version = SUNDOG_OCIO_ABI_VERSION;
    abi->role_size = sizeof(SundogOcioRole);
    abi->colour_space_size = sizeof(SundogOcioColourSpace);
    abi->view_size = sizeof(SundogOcioView);
    abi->look_size = sizeof(SundogOcioLook);
    abi->display_size = sizeof(SundogOcioDisplay);
    abi->headers_version = static_cast<uint32_t>(OCIO_VERSION_HEX);
    try {
        abi->library_version = static_cast<uint32_t>(OCIO::GetVersionHex());
    } catch (...) {
        return false;
    }
    return true;
}

void sundog_ocio_text_free(char *text)
{
    std::free(text);
}

char *sundog_ocio_take_log(void)
{
    try {
        const std::lock_guard<std::mutex> lock(log_mutex);
        if (log_text == nullptr || log_text->empty()) {
            return nullptr;
        }
        char *taken = copy_or_null(log_text->c_str());
        log_text->clear();
        return taken;
    } catch (...) {
        return nullptr;
    }
}

SundogOcioConfig *sundog_ocio_config_from_file(const char *path_or_uri, char **error)
{
    return make_config(error, [&] { return OCIO::Config::CreateFromFile(path_or_uri); });
}

SundogOcioConfig *sundog_ocio_config_from_text(const char *text, size_t length, char **error)
{
    return make_config(error, [&] {
        std::istringstream stream(std::string(text, length));
        return OCIO::Config::CreateFromStream(stream);
    });
}

SundogOcioConfig *sundog_ocio_config_raw(char **error)
{
    return make_config(error, [] { return OCIO::Config::CreateRaw(); });
}

void sundog_ocio_config_free(SundogOcioConfig *config)
{
    delete config;
}

bool sundog_ocio_config_name(const SundogOcioConfig *config, char **name, char **error)
{
    return guarded(error, [&] { *name = copy(config->config->getName()); });
}

bool sundog_ocio_config_description(const SundogOcioConfig *config, char **description, char **error)
{
    return guarded(error, [&] { *description = copy(config->config->getDescription()); });
}

bool sundog_ocio_config_profile(const SundogOcioConfig *config, uint32_t *major, uint32_t *minor, char **error)
{
    return guarded(error, [&] {
        *major = config->config->getMajorVersion();
        *minor = config->config->getMinorVersion();
    });
}

bool sundog_ocio_config_files(const SundogOcioConfig *config, char **paths, char **error)
{
    return guarded(error, [&] {
        const OCIO::ConstConfigRcPtr &from = config->config;
        const OCIO::ConstContextRcPtr context = from->getCurrentContext();
        std::string found;
        const auto everywhere = OCIO::SEARCH_REFERENCE_SPACE_ALL;
        const int spaces = from->getNumColorSpaces(everywhere, OCIO::COLORSPACE_ALL);
        for (int i = 0; i < spaces; ++i) {
            const char *name = from->getColorSpaceNameByIndex(everywhere, OCIO::COLORSPACE_ALL, i);
            if (const OCIO::ConstColorSpaceRcPtr space = from->getColorSpace(name)) {
                add_files(space->getTransform(OCIO::COLORSPACE_DIR_TO_REFERENCE), context, found);
                add_files(space->getTransform(OCIO::COLORSPACE_DIR_FROM_REFERENCE), context, found);
            }
        }
        for (int i = 0; i < from->getNumLooks(); ++i) {
            if (const OCIO::ConstLookRcPtr look = from->getLook(from->getLookNameByIndex(i))) {
                add_files(look->getTransform(), context, found);
                add_files(look->getInverseTransform(), context, found);
            }
        }
        for (int i = 0; i < from->getNumViewTransforms(); ++i) {
            if (const OCIO::ConstViewTransformRcPtr view = from->getViewTransform(from->getViewTransformNameByIndex(i))) {
                add_files(view->getTransform(OCIO::VIEWTRANSFORM_DIR_TO_REFERENCE), context, found);
                add_files(view->getTransform(OCIO::VIEWTRANSFORM_DIR_FROM_REFERENCE), context, found);
            }
        }
        const int named = from->getNumNamedTransforms(OCIO::NAMEDTRANSFORM_ALL);
        for (int i = 0; i < named; ++i) {
            const char *name = from->getNamedTransformNameByIndex(OCIO::NAMEDTRANSFORM_ALL, i);
            if (const OCIO::ConstNamedTransformRcPtr one = from->getNamedTransform(name)) {
                add_files(one->getTransform(OCIO::TRANSFORM_DIR_FORWARD), context, found);
                add_files(one->getTransform(OCIO::TRANSFORM_DIR_INVERSE), context, found);
            }
        }
        *paths = copy(found.c_str());
    });
}

bool sundog_ocio_role_count(const SundogOcioConfig *config, size_t *count, char **error)
{
    return guarded(error, [&] { *count = to_count(config->config->getNumRoles()); });
}

bool sundog_ocio_role(const SundogOcioConfig *config, size_t index, SundogOcioRole *role, char **error)
{
    SundogOcioRole made{};
    const bool ok = guarded(error, [&] {
        const int at = to_index(index, config->config->getNumRoles());
        made.name = copy(config->config->getRoleName(at));
        made.colour_space = copy(config->config->getRoleColorSpace(at));
    });
    if (!ok) {
        sundog_ocio_role_free(&made);
    }
    *role = made;
    return ok;
}

void sundog_ocio_role_free(SundogOcioRole *role)
{
    std::free(role->name);
    std::free(role->colour_space);
    *role = SundogOcioRole{};
}

bool sundog_ocio_colour_space_count(const SundogOcioConfig *config, size_t *count, char **error)
{
    return guarded(error, [&] { *count = to_count(config->config->getNumColorSpaces()); });
}

bool sundog_ocio_colour_space(const SundogOcioConfig *config, size_t index, SundogOcioColourSpace *space, char **error)
{
    SundogOcioColourSpace made{};
    const bool ok = guarded(error, [&] {
        const int at = to_index(index, config->config->getNumColorSpaces());
        const OCIO::ConstColorSpaceRcPtr found = config->config->getColorSpace(config->config->getColorSpaceNameByIndex(at));
        if (!found) {
            throw std::runtime_error("the configuration names a colour space that it does not have");
        }
        made.name = copy(found->getName());
        made.family = copy(found->getFamily());
        made.encoding = copy(found->getEncoding());
        made.description = copy(found->getDescription());
        made.is_data = found->isData();
        made.is_display_referred = found->getReferenceSpaceType() == OCIO::REFERENCE_SPACE_DISPLAY;
    });
    if (!ok) {
        sundog_ocio_colour_space_free(&made);
    }
    *space = made;
    return ok;
}

void sundog_ocio_colour_space_free(SundogOcioColourSpace *space)
{
    std::free(space->name);
    std::free(space->family);
    std::free(space->encoding);
    std::free(space->description);
    *space = SundogOcioColourSpace{};
}

bool sundog_ocio_has_colour_space(const SundogOcioConfig *config, const char *name, bool *has, char **error)
{
    return guarded(error, [&] { *has = config->config->getColorSpace(name) != nullptr; });
}

bool sundog_ocio_display_count(const SundogOcioConfig *config, size_t *count, char **error)
{
    return guarded(error, [&] { *count = to_count(config->config->getNumDisplays()); });
}

bool sundog_ocio_display(const SundogOcioConfig *config, size_t index, char **name, char **error)
{
    return guarded(error, [&] {
        const int at = to_index(index, config->config->getNumDisplays());
        *name = copy(config->config->getDisplay(at));
    });
}

bool sundog_ocio_default_display(const SundogOcioConfig *config, char **name, char **error)
{
    return guarded(error, [&] { *name = copy(config->config->getDefaultDisplay()); });
}

bool sundog_ocio_view_count(const SundogOcioConfig *config, const char *display, size_t *count, char **error)
{
    return guarded(error, [&] { *count = to_count(config->config->getNumViews(display)); });
}

bool sundog_ocio_view(
    const SundogOcioConfig *config, const char *display, size_t index, SundogOcioView *view, char **error)
{
    SundogOcioView made{};
    const bool ok = guarded(error, [&] {
        const int at = to_index(index, config->config->getNumViews(display));
        made.name = copy(config->config->getView(display, at));
        made.colour_space = copy(config->config->getDisplayViewColorSpaceName(display, made.name));
        made.view_transform = copy(config->config->getDisplayViewTransformName(display, made.name));
        made.looks = copy(config->config->getDisplayViewLooks(display, made.name));
        made.description = copy(config->config->getDisplayViewDescription(display, made.name));
    });
    if (!ok) {
        sundog_ocio_view_free(&made);
    }
    *view = made;
    return ok;
}

bool sundog_ocio_default_view(const SundogOcioConfig *config, const char *display, char **name, char **error)
{
    return guarded(error, [&] { *name = copy(config->config->getDefaultView(display)); });
}

void sundog_ocio_view_free(SundogOcioView *view)
{
    std::free(view->name);
    std::free(view->colour_space);
    std::free(view->view_transform);
    std::free(view->looks);
    std::free(view->description);
    *view = SundogOcioView{};
}

bool sundog_ocio_look_count(const SundogOcioConfig *config, size_t *count, char **error)
{
    return guarded(error, [&] { *count = to_count(config->config->getNumLooks()); });
}

bool sundog_ocio_look(const SundogOcioConfig *config, size_t index, SundogOcioLook *look, char **error)
{
    SundogOcioLook made{};
    const bool ok = guarded(error, [&] {
        const int at = to_index(index, config->config->getNumLooks());
        const OCIO::ConstLookRcPtr found = config->config->getLook(config->config->getLookNameByIndex(at));
        if (!found) {
            throw std::runtime_error("the configuration names a look that it does not have");
        }
        made.name = copy(found->getName());
        made.process_space = copy(found->getProcessSpace());
        made.description = copy(found->getDescription());
    });
    if (!ok) {
        sundog_ocio_look_free(&made);
    }
    *look = made;
    return ok;
}

void sundog_ocio_look_free(SundogOcioLook *look)
{
    std::free(look->name);
    std::free(look->process_space);
    std::free(look->description);
    *look = SundogOcioLook{};
}

bool sundog_ocio_is_scene_linear_rec709(const SundogOcioConfig *config, bool *is, char **error)
{
    return guarded(error, [&] {
        const OCIO::ConstCPUProcessorRcPtr inwards =
            OCIO::Config::GetProcessorFromBuiltinColorSpace(
                builtin_linear_rec709, config->config, OCIO::ROLE_SCENE_LINEAR)
                ->getDefaultCPUProcessor();
        // Configurations write their matrices with so few digits that Blender 4.5's is 3e-4 off. Between Rec.709 and
        // any other working space there is more than 1e-2.
        constexpr float same = 2e-3f;
        const float corners[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
        *is = true;
        for (const auto &corner : corners) {
            float turned[3] = {corner[0], corner[1], corner[2]};
            inwards->applyRGB(turned);
            for (int channel = 0; channel < 3; ++channel) {
                // Written so that NaN is not the same.
                if (!(std::fabs(turned[channel] - corner[channel]) < same)) {
                    *is = false;
                }
            }
        }
    });
}

SundogOcioProcessor *sundog_ocio_convert_processor(
    const SundogOcioConfig *config, const char *source, const char *destination, char **error)
{
    return make_processor(error, [&] { return config->config->getProcessor(source, destination); });
}

SundogOcioProcessor *sundog_ocio_display_processor(
    const SundogOcioConfig *config, const SundogOcioDisplay *display, size_t display_size, char **error)
{
    return make_processor(error, [&] {
        if (display_size != sizeof(SundogOcioDisplay)) {
            throw std::runtime_error("SundogOcioDisplay has another size than the shim was compiled with");
        }
        const OCIO::GroupTransformRcPtr chain = OCIO::GroupTransform::Create();

        // Where the pixels are so far.
        std::string space = OCIO::ROLE_SCENE_LINEAR;
        if (!display->from_scene_linear) {
            const OCIO::ConstProcessorRcPtr inwards = OCIO::Config::GetProcessorFromBuiltinColorSpace(
                builtin_linear_rec709, config->config, OCIO::ROLE_SCENE_LINEAR);
            chain->appendTransform(inwards->createGroupTransform());
        }

        // Exposure is a matter of light.
        if (display->scale != 1.0) {
            chain->appendTransform(scale_by(display->scale));
        }

        // The look ends in its own process space, and the view starts from there: what is done by hand here, so that
        // the looks which the view brings along are replaced and not added to.
        bool own_look = false;
        if (display->look != nullptr && display->look[0] != '\0') {
            const char *result = OCIO::LookTransform::GetLooksResultColorSpace(
                config->config, config->config->getCurrentContext(), display->look);
            if (result != nullptr && result[0] != '\0') {
                const std::string process_space = result;
                const OCIO::LookTransformRcPtr look = OCIO::LookTransform::Create();
                look->setSrc(space.c_str());
                look->setDst(process_space.c_str());
                look->setLooks(display->look);
                chain->appendTransform(look);
                space = process_space;
                own_look = true;
            }
        }

        const OCIO::DisplayViewTransformRcPtr view = OCIO::DisplayViewTransform::Create();
        view->setSrc(space.c_str());
        view->setDisplay(display->display);
        view->setView(display->view);
        view->setLooksBypass(own_look);
        chain->appendTransform(view);

        if (display->exponent != 1.0) {
            const OCIO::ExponentTransformRcPtr gamma = OCIO::ExponentTransform::Create();
            const double exponent[4] = {display->exponent, display->exponent, display->exponent, 1.0};
            gamma->setValue(exponent);
            chain->appendTransform(gamma);
        }

        if (display->display_scale != 1.0) {
            const std::string own_space = config->config->getDisplayViewColorSpaceName(display->display, display->view);
            const char *display_space = own_space == OCIO::OCIO_VIEW_USE_DISPLAY_NAME ? display->display : own_space.c_str();
            chain->appendTransform(convert(display_space, OCIO::ROLE_INTERCHANGE_DISPLAY));
            chain->appendTransform(scale_by(display->display_scale));
            chain->appendTransform(convert(OCIO::ROLE_INTERCHANGE_DISPLAY, display_space));
        }
        return config->config->getProcessor(chain);
    });
}

void sundog_ocio_processor_free(SundogOcioProcessor *processor)
{
    delete processor;
}

bool sundog_ocio_processor_is_identity(const SundogOcioProcessor *processor, bool *identity, char **error)
{
    return guarded(error, [&] { *identity = processor->cpu->isNoOp(); });
}

bool sundog_ocio_apply(
    const SundogOcioProcessor *processor, float *pixels, size_t count, size_t channels, char **error)
{
    return guarded(error, [&] {
        if (channels != 3 && channels != 4) {
            throw std::invalid_argument("pixels have 3 or 4 channels");
        }
        // OpenColorIO counts in `long`, and some of its loops in `int`: one "row" at a time stays far below both.
        constexpr size_t row = size_t(1) << 20;
        while (count > 0) {
            const size_t now = count < row ? count : row;
            OCIO::PackedImageDesc image(pixels, static_cast<long>(now), 1, static_cast<long>(channels));
            processor->cpu->apply(image);
            pixels += now * channels;
            count -= now;
        }
    });
}
