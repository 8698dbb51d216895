//! Arguments that several commands share.

use super::values::{self, Kinds, words};
use super::values::{Color, MAX_BOUNCES, MAX_SAMPLES, Roulette};
use super::words::*;
use crate::color::Depth;
use crate::denoise::{Choice, Guides, Prefilter, Quality};
use crate::film::Passes;
use crate::film::objects::Mist;
use crate::import::{LightUnits, Transmission};
use crate::nodes::CyclesVersion;
use crate::output::exr::SampleType;
use crate::render::{
    Caustics, EffectChoice, Filter, InstructionSet, LightSampling, MAX_BRANCHES, MAX_LIGHT_SAMPLES,
    MAX_SIDE, Region,
};
use crate::scene::LightGrouping;
use clap::{ArgAction, Args};
use exr::compression::Compression;
use std::path::PathBuf;

/// How a scene file is read.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Scene")]
pub struct Import {
    /// The glTF scene to load, where the file has more than one.
    #[arg(long = "scene", value_name = "NAME|INDEX")]
    pub scene_name: Option<String>,
    /// The variant that is shown, where the file has variants; its own choice if not given.
    ///
    /// In glTF a name; in USD a set and a name, as in shape=round. Several are given one by one, or with commas between them.
    #[arg(long, value_name = "[SET=]NAME")]
    pub variant: Vec<String>,
    /// What the light intensities of the file mean: the "Lighting Mode" it was exported with.
    #[arg(long, value_name = "UNITS", value_parser = words(&LIGHT_UNITS), default_value = "auto")]
    pub light_units: LightUnits,
    /// What glTF's transmission means where the file gives no thickness.
    #[arg(long, value_name = "MEANING", value_parser = words(&TRANSMISSION), default_value = "auto")]
    pub transmission: Transmission,
    /// The version of Cycles whose nodes are computed, such as 4.5; that of the Blender that wrote the file if not given.
    ///
    /// Where versions differ (docs/cycles.md says where), patterns of a node tree are those of this one.
    #[arg(long, value_name = "VERSION", value_parser = values::cycles)]
    pub cycles: Option<CyclesVersion>,
    /// The frame at which an animation of the file poses it: a number, at Blender's 24 frames a second or at others, such as 12@30.
    ///
    /// Nodes, skins and weights of morph targets. In files of Blender's exporter frame 0 is at 0 seconds, unless
    /// "Set all glTF Animation starting at 0" was ticked. In USD a number without a rate is a time code of the stage.
    #[arg(long, value_name = "NUMBER[@RATE]", value_parser = values::frame, allow_hyphen_values = true)]
    pub frame: Option<values::Frame>,
    /// The same by seconds.
    #[arg(long, value_name = "SECONDS", conflicts_with = "frame", number = -1e6..=1e6)]
    pub seconds: Option<f64>,
    /// Which animation that is, by its name or number; the first if not given.
    #[arg(long, value_name = "NAME|INDEX")]
    pub animation: Option<String>,
    /// Read files that the scene names and that do not lie in its folder or below it.
    ///
    /// For scenes that you trust: an absolute path, `../` or a symbolic link in a file from elsewhere may lead to
    /// anything that you can read.
    #[arg(long)]
    pub allow_outside: bool,
    /// Read KHR_materials_volume_scatter, as far as its draft goes: what fills a solid scatters light.
    ///
    /// The extension is not ratified and may change. Without the flag such solids only absorb, which is told.
    #[arg(long)]
    pub gltf_scatter: bool,
    /// The most memory that the images of a scene may take, and the most for the grids of volumes, such as 4G or 500M.
    ///
    /// Where images would take more, the largest lie in a scratch file, of which so much is in memory at a time: the
    /// picture is the same, and each is named. Without room on a disk ($TMPDIR, /var/tmp) they are read with half as many
    /// pixels along each side, and so on, which blurs them. A grid that would take more is not read, which is told, and is
    /// empty. If not given, images are read into memory, and grids may take what is free.
    #[arg(long, value_name = "SIZE", value_parser = values::size)]
    pub max_memory: Option<u64>,
}

/// How a scene that is rendered is read.
#[derive(Args, Clone, Debug)]
pub struct Loading {
    #[command(flatten)]
    pub import: Import,
    /// Stop before rendering if anything in the scene is approximated or left out.
    #[arg(long, help_heading = "Scene")]
    pub strict: bool,
}

/// What lights the scene from all around.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Environment")]
pub struct Environment {
    /// Light from all around: an equirectangular picture, .exr or .hdr.
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// Light from all around of one colour: radiance, linear Rec.709.
    ///
    /// Not together with `--environment`.
    #[arg(long, value_name = "R,G,B", value_parser = values::color)]
    pub environment_color: Option<Color>,
    /// Multiplies the environment, as the strength of Blender's Background node does.
    #[arg(long, value_name = "FACTOR", number = 0.0..=1e9, preset = "1")]
    pub environment_strength: Option<f64>,
    /// Turns the environment about the up axis, in the sense of the Z rotation of Blender's Mapping node.
    #[arg(long, value_name = "DEGREES", number = -1e6..=1e6, preset = "0")]
    pub environment_rotation: Option<f64>,
}

/// How linear light is seen.
#[derive(Args, Clone, Debug)]
pub struct Seen {
    /// OpenColorIO configuration: a .ocio or .ocioz file, or an ocio:// name.
    ///
    /// If not given: `$OCIO`, an installed Blender or bpy, or else the configuration built into OpenColorIO.
    #[arg(long, value_name = "CONFIG")]
    pub ocio: Option<String>,
    /// Display; the configuration's default if not given.
    #[arg(long, value_name = "NAME")]
    pub display: Option<String>,
    /// View of the display, such as AgX, Filmic or Standard.
    #[arg(long, value_name = "NAME")]
    pub view: Option<String>,
    /// Look on top of the view.
    ///
    /// One that goes with the view; `Punchy` is enough for `AgX - Punchy` with the view AgX, where no look has just
    /// the short name.
    #[arg(long, value_name = "NAME")]
    pub look: Option<String>,
    /// Exposure before the view: 1 doubles the light.
    #[arg(long, value_name = "STOPS", number = -32.0..=32.0, preset = "0")]
    pub exposure: Option<f64>,
    /// Gamma after the view: display values are raised to 1/GAMMA.
    #[arg(long, value_name = "GAMMA", number = 0.01..=100.0, preset = "1")]
    pub gamma: Option<f64>,
}

/// How PNG and JPEG files are made.
#[derive(Args, Clone, Debug)]
pub struct View {
    #[command(flatten)]
    pub seen: Seen,
    /// Bits a channel of PNG files.
    #[arg(long, value_name = "BITS", value_parser = words(&DEPTHS), preset = "8")]
    pub depth: Option<Depth>,
    /// Quality of JPEG files.
    #[arg(long, value_name = "PERCENT", whole = 1..=100, preset = "90")]
    pub quality: Option<u32>,
}

/// How EXR files are written.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "EXR")]
pub struct Exr {
    /// Number format of EXR files.
    #[arg(long, value_name = "TYPE", value_parser = words(&EXR_TYPES), default_value = "float")]
    pub exr_type: SampleType,
    /// Compression of EXR files.
    #[arg(long, value_name = "METHOD", value_parser = words(&EXR_COMPRESSIONS), default_value = "zip")]
    pub exr_compression: Compression,
    /// Which layers EXR files have.
    #[arg(long, value_name = "LAYERS", action = ArgAction::Set, value_parser = words(&EXR_LAYERS), default_value = "all")]
    pub exr_layers: bool,
}

/// What is told.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Messages")]
pub struct Reporting {
    /// Say nothing but errors.
    #[arg(short = 'q', long)]
    pub quiet: bool,
    /// Tell what happens on the standard output, one JSON object a line.
    #[arg(long)]
    pub json: bool,
}

/// What of the scene is pictured, and how large.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Picture")]
pub struct Size {
    /// Pixels a row.
    ///
    /// If only one of width and height is given, the other follows from the camera's aspect; if none is, the
    /// scene's own size holds (SUNDOG_scene), or else the longer side has 1280 pixels.
    #[arg(long, value_name = "PIXELS", whole = 1..=MAX_SIDE)]
    pub width: Option<u32>,
    /// Rows.
    #[arg(long, value_name = "PIXELS", whole = 1..=MAX_SIDE)]
    pub height: Option<u32>,
    /// Render only these pixels of the picture: from the column X0 and the row Y0, counted from the top left, up to
    /// and without X1 and Y1.
    ///
    /// The files hold these pixels alone. They are the same, bit for bit, as in the full picture.
    #[arg(long, value_name = "X0,Y0,X1,Y1")]
    pub region: Option<Region>,
    /// The camera, by name or by number from 0; the first one if not given.
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
    /// Leave the world out of the picture: where the camera looks straight at it (or through alpha), alpha is 0.
    #[arg(long)]
    pub transparent: bool,
    /// Leave the world out of the picture behind glass up to a roughness, too, where --transparent does so: Cycles' Transparent Glass.
    ///
    /// Passes tell what is behind such glass as what is behind any: as transmission.
    #[arg(long, value_name = "ROUGHNESS", number = 0.0..=1.0)]
    pub transparent_glass: Option<f64>,
    /// Factor on all light of the picture, as Cycles' film exposure; the scene's if not given.
    ///
    /// Combined and the passes of light are scaled; what surfaces are like (colours, albedo, normals, depth) is
    /// not. Not the exposure of the view, which --exposure is.
    #[arg(long, value_name = "FACTOR", number = 0.0..=10_240.0, preset = "1")]
    pub film_exposure: Option<f64>,
    /// Pixel filter and its width in pixels, as Blender counts it.
    ///
    /// One of blackman-harris, gauss and box; the box is one pixel wide. blackman-harris reaches as far as its
    /// width from the middle of the pixel; gauss has a standard deviation of a quarter of its width. If not given:
    /// the scene's own width (SUNDOG_scene).
    #[arg(long, value_name = "FILTER[:WIDTH]", preset = "blackman-harris:1.5")]
    pub filter: Option<Filter>,
}

/// Which passes a picture has.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Picture")]
pub struct ChosenPasses {
    /// Which passes the last frame and EXR files have, by Blender's names with commas between them; `all` for all.
    ///
    /// Combined is always among them. What each of them holds stands below.
    #[arg(
        long,
        value_name = "LIST",
        default_value = "Combined,Depth,Normal,Position,Debug Sample Count,Error"
    )]
    pub passes: Passes,
    /// Blender's mist for the pass Mist: where it begins, how far it takes to be all, and the power of what lies between.
    ///
    /// Metres. The power is 2 for Blender's Quadratic, 1 for Linear and 0.5 for Inverse Quadratic.
    #[arg(long, value_name = "START,DEPTH,POWER", value_parser = values::mist, default_value = "5,25,2")]
    pub mist: Mist,
    /// How far the pass AO looks for what is in the way, metres.
    #[arg(long, value_name = "METRES", number = 0.0..=1e9, default_value = "10")]
    pub ao_distance: f64,
    /// How much of a surface has to be there for passes of data to stop at it: Blender's Alpha Threshold.
    ///
    /// Depth, Position, IndexOB, IndexMA, Normal, UV and Vector look through what is fainter, by chance. Images decide for each ray
    /// whether something is there, or not.
    #[arg(long, value_name = "SHARE", number = 0.0..=1.0, default_value = "0.5")]
    pub alpha_threshold: f64,
    /// Data without filtering: normals, UV, mist and Cryptomatte are of the ray through each pixel's middle.
    ///
    /// Depth, Position, IndexOB and IndexMA always are. Edges are then not smooth, and no value is a mean of two surfaces: for data
    /// sets. Colours, AOVs, AO and passes for denoisers are filtered as ever.
    #[arg(long)]
    pub centre_passes: bool,
    /// Which lights have a pass of their own together: Combined_GROUP for each light group.
    #[arg(long, value_name = "WHICH", value_parser = words(&LIGHT_GROUPS), default_value = "file")]
    pub light_groups: LightGrouping,
}

/// How noise is taken out at the end.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Denoising")]
pub struct Denoising {
    /// Take the noise out of the finished picture, with Open Image Denoise.
    ///
    /// The noisy picture stays in EXR files and the last frame, as the pass Noisy Image. How much brightness moved is told
    /// (docs/accuracy.md). The library is opened then alone: from `$OIDN_DIR`, `make setup`, an installed Blender or the
    /// system. A render that is interrupted is not denoised.
    #[arg(long)]
    pub denoise: bool,
    /// What is done about noise in the guides.
    #[arg(long, value_name = "HOW", requires = "denoise", value_parser = words(&PREFILTERS), default_value = "accurate")]
    pub denoise_prefilter: Prefilter,
    /// Passes that tell the denoiser edges and textures from noise.
    #[arg(long, value_name = "PASSES", requires = "denoise", value_parser = words(&GUIDES), default_value = "albedo-normal")]
    pub denoise_guides: Guides,
    /// How much work the denoiser does.
    #[arg(long, value_name = "QUALITY", requires = "denoise", value_parser = words(&QUALITIES), default_value = "high")]
    pub denoise_quality: Quality,
    /// Give back the brightness that denoising moved: of blocks as far as it is certain, of the whole exactly.
    #[arg(long, requires = "denoise")]
    pub denoise_keep_energy: bool,
    /// Passes of light that are denoised as well: their names with commas between them, or `all` for each that can be.
    ///
    /// Of those that the picture has: DiffDir to TransInd without colours, VolumeDir, VolumeInd, Emit, Env, AO, and light groups as
    /// Combined_GROUP. Each stays beside as it was, as Noisy and its name. Shadow Catcher always is, as in Cycles.
    #[arg(long, value_name = "LIST", requires = "denoise")]
    pub denoise_passes: Option<Choice>,
    /// Where the denoiser is missing or fails, warn and keep the noisy picture.
    #[arg(long, requires = "denoise")]
    pub denoise_optional: bool,
}

/// How long paths may be.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Bounces")]
pub struct Bounces {
    /// Bounces of a path, as Cycles counts its Max Bounces: 0 is direct light alone.
    #[arg(long, value_name = "COUNT", whole = 0..=MAX_BOUNCES, default_value = "12")]
    pub bounces: u32,
    /// Diffuse reflections of a path, as Cycles counts its Max Bounces for Diffuse.
    ///
    /// No limit if not given.
    #[arg(long, value_name = "COUNT", whole = 0..=MAX_BOUNCES)]
    pub bounces_diffuse: Option<u32>,
    /// The same for glossy reflections, mirrors included.
    ///
    /// No limit if not given.
    #[arg(long, value_name = "COUNT", whole = 0..=MAX_BOUNCES)]
    pub bounces_glossy: Option<u32>,
    /// The same for passages through glass: a solid takes two.
    ///
    /// No limit if not given.
    #[arg(long, value_name = "COUNT", whole = 0..=MAX_BOUNCES)]
    pub bounces_transmission: Option<u32>,
    /// The same for scatterings by volumes; 0 leaves the light of lamps that is scattered once.
    ///
    /// No limit if not given.
    #[arg(long, value_name = "COUNT", whole = 0..=MAX_BOUNCES)]
    pub bounces_volume: Option<u32>,
    /// Surfaces that a path may pass by their opacity, and a shadow ray from its end, as Cycles counts them: they
    /// are no bounces.
    ///
    /// No limit if not given.
    #[arg(long, value_name = "COUNT", whole = 0..=MAX_BOUNCES)]
    pub bounces_transparent: Option<u32>,
}

/// Which effects are simulated.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Light transport")]
pub struct ChosenEffects {
    /// Which effects are simulated.
    ///
    /// `auto` takes what the scene calls for, `all` everything there is; a list of names with commas between them
    /// takes these and leaves out what the scene calls for beyond them, which is told once and written into the
    /// picture (docs/effects.md).
    #[arg(long, value_name = "auto|all|LIST", default_value = "auto")]
    pub effects: EffectChoice,
}

/// How light is simulated.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Light transport")]
pub struct Transport {
    /// Greatest value (mean of the channels) of one contribution of direct light, and of what the camera sees
    /// itself; 0 for no limit.
    ///
    /// Biased: takes light away, as Cycles' Clamp Direct does. How much is told at the end.
    #[arg(long, value_name = "VALUE", number = 0.0..=1e9, default_value = "0")]
    pub clamp_direct: f64,
    /// The same for indirect light; 0 for no limit.
    ///
    /// Biased: takes light away, above all caustics, as Cycles' Clamp Indirect does, which is 10 by default there.
    /// How much is told at the end.
    #[arg(long, value_name = "VALUE", number = 0.0..=1e9, default_value = "0")]
    pub clamp_indirect: f64,
    /// Clamps light samples as if they were shared out as Cycles does without its Light Tree: half of them to surfaces that emit,
    /// by their areas, the others evenly to lamps, suns and the world.
    ///
    /// The same picture but for clamping, which takes more from lights that are drawn more seldom, and a little more noise; and for
    /// light behind steep bumps or below smooth normals and light that only some rays find, as through glass that casts no shadow.
    #[arg(long)]
    pub even_lights: bool,
    /// Clamps light samples as if they were shared out as Cycles does with its Light Tree.
    ///
    /// The same picture but for clamping, which takes more from lights that are drawn more seldom, and a little more noise.
    /// Light that only some rays find counts so without it, too, in files from Blender.
    #[arg(long, conflicts_with = "even_lights")]
    pub tree_lights: bool,
    /// Makes reflection and refraction rougher behind blurring bounces, as Cycles' Filter Glossy; 0 for off.
    ///
    /// Biased: caustics get soft. Cycles has 1 by default.
    #[arg(long, value_name = "VALUE", number = 0.0..=1e6, default_value = "0")]
    pub filter_glossy: f64,
    /// Which caustics there are: what reflects or lets through where a path comes to it from a diffuse reflection.
    ///
    /// Biased: all but `all` take light away, as Cycles' switches of the same names do.
    #[arg(long, value_name = "KINDS", value_parser = words(&CAUSTICS), default_value = "all")]
    pub caustics: Caustics,
    /// Hide the back faces of single-sided materials, as glTF viewers do and Cycles does not.
    #[arg(long)]
    pub backface_culling: bool,
}

/// How light is looked for.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Studies")]
pub struct Studies {
    /// How paths find light; mis is the one to use, the others show why.
    ///
    /// All have the same picture in the mean.
    #[arg(long, value_name = "TECHNIQUE", value_parser = words(&LIGHT_SAMPLING), default_value = "mis")]
    pub light_sampling: LightSampling,
    /// Light samples at the surface that the camera sees, of which the mean counts; at all others it is one.
    ///
    /// The same picture in the mean.
    #[arg(long, value_name = "COUNT", whole = 1..=MAX_LIGHT_SAMPLES, default_value = "1")]
    pub light_samples: u32,
    /// Paths that go on from what the camera sees, for each sample; their mean counts.
    ///
    /// The same picture in the mean. Where fog scatters light more than once it is 4,
    /// or 2 if the fog varies; otherwise 1.
    #[arg(long, value_name = "COUNT", whole = 1..=MAX_BRANCHES)]
    pub branches: Option<u32>,
    /// From which bounce on paths that carry little light may end by chance; `on` is 2, `off` follows each to its
    /// last bounce.
    ///
    /// The same picture in the mean.
    #[arg(long, value_name = "on|off|BOUNCE", value_parser = values::roulette, default_value = "on")]
    pub roulette: Roulette,
    /// Leave out something that keeps pictures stable, to see what it is good for and what it costs.
    ///
    /// Pictures get wrong: docs/hard-cases.md shows how.
    #[arg(long, value_name = "PART", value_parser = words(&NAIVE))]
    pub naive: Vec<&'static str>,
}

/// What computes, and with which random numbers.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Effort")]
pub struct Machine {
    /// Threads; all the processor has if not given.
    ///
    /// The picture does not depend on it.
    #[arg(long, value_name = "COUNT", whole = 1..=1024)]
    pub threads: Option<u32>,
    /// Instructions by which rays meet surfaces.
    ///
    /// The last bits of the picture depend on it, so that machines that share a picture need the same: ask for
    /// sse4.2 where one of them lacks AVX2. Better instructions of a newer processor are not taken. The variable
    /// `SUNDOG_INSTRUCTION_SET` asks for it where no flag does.
    #[arg(long, value_name = "NAME", value_parser = words(&INSTRUCTION_SETS))]
    pub instruction_set: Option<InstructionSet>,
    /// Selects another independent random sequence.
    #[arg(long, value_name = "NUMBER", whole = 0..=u32::MAX, default_value = "0")]
    pub seed: u32,
    /// Random sequences that the samples of a pixel are of: two by turns, which tell the error without bias, or one.
    ///
    /// One is spread more evenly, so that there is less noise where light is smooth. Its error is told too large, as its halves
    /// differ by more than independent ones; the interval begins at 0. Cycles has one.
    #[arg(long, value_name = "COUNT", whole = 1..=2, default_value = "2")]
    pub sequences: u32,
    /// With `--sequences 1`: so many samples of each pixel are spread evenly with those of its neighbours; `--samples` if not given.
    ///
    /// The noise of neighbours is then of opposite signs rather than alike, which is seen less and denoised better. A render that
    /// goes on with more samples, and parts that are joined, need the same number.
    #[arg(long, value_name = "COUNT", whole = 1..=MAX_SAMPLES, requires = "sequences")]
    pub planned_samples: Option<u32>,
}

/// What all commands that render have in common.
#[derive(Args, Clone, Debug)]
pub struct RenderOptions {
    #[command(flatten)]
    pub machine: Machine,
    #[command(flatten)]
    pub size: Size,
    #[command(flatten)]
    pub bounces: Bounces,
    #[command(flatten)]
    pub transport: Transport,
    #[command(flatten)]
    pub studies: Studies,
    #[command(flatten)]
    pub loading: Loading,
    #[command(flatten)]
    pub environment: Environment,
}
