//! Arguments that take one of a few words: each with what it means and what it stands for.

use super::values::Word;
use crate::color::Depth;
use crate::denoise::{Guides, Prefilter, Quality};
use crate::selftest::Effort;
use crate::import::{LightUnits, Transmission};
use crate::output::exr::SampleType;
use crate::render::{Caustics, InstructionSet, LightSampling};
use crate::scene::LightGrouping;
use clap_complete::Shell;
use exr::compression::Compression;

/// `--light-units`.
pub static LIGHT_UNITS: [Word<LightUnits>; 4] = [
    ("auto", "\"standard\" or \"unitless\", by the program that wrote the file and by how bright its lamps come out; which, and why, is told", LightUnits::Auto),
    ("standard", "photometric, as KHR_lights_punctual has it: 683 lm are a watt", LightUnits::Standard),
    ("unitless", "radiometric: Blender's \"Unitless\"", LightUnits::Unitless),
    ("raw", "Blender's own numbers: its \"Raw\"", LightUnits::Raw),
];

/// `--transmission`.
pub static TRANSMISSION: [Word<Transmission>; 3] = [
    ("auto", "solid in files by Blender's exporter, thin otherwise", Transmission::Auto),
    ("solid", "the surface bounds a solid and refracts", Transmission::Solid),
    ("thin", "the surface is a thin sheet, as the extension says", Transmission::Thin),
];

/// `--light-groups`.
pub static LIGHT_GROUPS: [Word<LightGrouping>; 3] = [
    ("file", "those of the file", LightGrouping::File),
    ("each", "one for each lamp and each object that shines, by their names, and one for the world", LightGrouping::Each),
    ("none", "none", LightGrouping::None),
];

/// `--depth`.
pub static DEPTHS: [Word<Depth>; 2] = [
    ("8", "8 bits a channel", Depth::Eight),
    ("16", "16 bits a channel (PNG)", Depth::Sixteen),
];

/// `--exr-type`.
pub static EXR_TYPES: [Word<SampleType>; 2] = [
    ("float", "32 bits", SampleType::Float),
    ("half", "16 bits; depth, position and sample count stay at 32, values above 65504 become 65504", SampleType::Half),
];

/// `--exr-compression`.
pub static EXR_COMPRESSIONS: [Word<Compression>; 5] = [
    ("zip", "lossless, 16 lines at a time", Compression::ZIP16),
    ("zips", "lossless, line by line", Compression::ZIP1),
    ("piz", "lossless, wavelets: good for noisy pictures", Compression::PIZ),
    ("rle", "lossless, quick", Compression::RLE),
    ("none", "as it is", Compression::Uncompressed),
];

/// `--exr-layers`.
pub static EXR_LAYERS: [Word<bool>; 2] = [
    ("all", "those that `--passes` names", true),
    ("combined", "the picture alone, which Blender then reads as a plain image", false),
];

/// `--denoise-prefilter`.
pub static PREFILTERS: [Word<Prefilter>; 3] = [
    ("none", "guides are taken to have no noise", Prefilter::None),
    ("fast", "colour and noisy guides together", Prefilter::Fast),
    ("accurate", "guides are denoised first", Prefilter::Accurate),
];

/// `--denoise-guides`.
pub static GUIDES: [Word<Guides>; 3] = [
    ("none", "the colour alone", Guides::None),
    ("albedo", "the albedo", Guides::Albedo),
    ("albedo-normal", "albedo and normal", Guides::AlbedoNormal),
];

/// `--denoise-quality`.
pub static QUALITIES: [Word<Quality>; 3] = [
    ("fast", "least time", Quality::Fast),
    ("balanced", "between both", Quality::Balanced),
    ("high", "the library's best", Quality::High),
];

/// `--caustics`.
pub static CAUSTICS: [Word<Caustics>; 4] = [
    ("all", "as light does", caustics(true, true)),
    ("reflective", "no caustics through glass", caustics(true, false)),
    ("refractive", "no caustics of reflections", caustics(false, true)),
    ("none", "neither", caustics(false, false)),
];

/// `--light-sampling`.
pub static LIGHT_SAMPLING: [Word<LightSampling>; 4] = [
    ("mis", "light sampling and BSDF sampling, weighted by multiple importance sampling", LightSampling::Mis),
    ("nee", "light sampling (next-event estimation) wherever it can find the light", LightSampling::Nee),
    ("bsdf", "BSDF sampling wherever it can find the light", LightSampling::Bsdf),
    ("hemisphere", "directions drawn uniformly, whatever the surface, wherever these can find the light", LightSampling::Hemisphere),
];

/// `--naive`.
pub static NAIVE: [Word<&'static str>; 4] = [
    ("offsets", "rays start a ten-thousandth of a metre off surfaces, instead of by derived error bounds", "offsets"),
    ("edges", "triangles are met by Embree's fast test, which lets rays through at edges", "edges"),
    ("origin", "positions become single-precision numbers where they are, instead of relative to the camera", "origin"),
    ("terminator", "directions below a triangle are lost, although the smooth surface that it stands for sees them", "terminator"),
];

/// `--instruction-set`.
pub static INSTRUCTION_SETS: [Word<InstructionSet>; 2] = [
    ("avx2", "most processors since 2013; what is taken where the processor has it", InstructionSet::Avx2),
    ("sse4.2", "all processors since 2011; what is taken elsewhere", InstructionSet::Sse42),
];

/// `--effort`.
pub static EFFORTS: [Word<Effort>; 3] = [
    ("quick", "a second or less for each case", Effort::Quick),
    ("thorough", "some seconds: what the project's own tests do", Effort::Thorough),
    ("long", "minutes", Effort::Long),
];

/// `SHELL`.
pub static SHELLS: [Word<Shell>; 5] = [
    ("bash", "Bash", Shell::Bash),
    ("elvish", "Elvish", Shell::Elvish),
    ("fish", "fish", Shell::Fish),
    ("powershell", "PowerShell", Shell::PowerShell),
    ("zsh", "Z shell", Shell::Zsh),
];

const fn caustics(reflective: bool, refractive: bool) -> Caustics {
    Caustics {
        reflective,
        refractive,
    }
}
