//! The commands and their arguments: their comments are the help.

use super::groups::*;
use super::pages;
use super::values::{self, Kinds, MAX_SAMPLES, Sample, SampleRange, words};
use super::words::*;
use crate::output::tev::Address;
use crate::render::MAX_SIDE;
use crate::selftest::Effort;
use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use std::path::PathBuf;
use std::time::Duration;

/// What `sundog render` reads and writes.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Files")]
pub struct RenderFiles {
    /// The scene: a .glb or .gltf file as Blender exports it, or USD: .usda, .usdc, .usd, .usdz.
    #[arg(id = "SCENE", value_name = "SCENE")]
    pub scene: PathBuf,
    /// Where the picture goes: .exr, .png or .jpg; may be given more than once.
    ///
    /// At least one, or `--frames` or `--checkpoint`.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Write the picture as raw floats while it grows, for programs: see below; needs `--json`.
    #[arg(long, value_name = "FOLDER")]
    pub frames: Option<PathBuf>,
    /// Show the picture while it grows in the image viewer tev that listens there.
    ///
    /// Under the name of the first file, a few times a second; all passes at the end. If nobody listens, or no
    /// longer, a warning says so and the render goes on.
    #[arg(long, value_name = "HOST[:PORT]")]
    pub tev: Option<Address>,
    /// Instead of a picture: print the path of one of its samples, vertex by vertex, with all densities and
    /// weights.
    ///
    /// Column and row from the top left, both from 0, and the number of the sample, as a render names those that
    /// were not finite. All other flags have to be those of the render. With `--json` as one object.
    #[arg(long, value_name = "X,Y,SAMPLE", value_parser = values::sample)]
    pub replay: Option<Sample>,
}

/// How long `sundog render` goes on.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Effort")]
pub struct RenderEffort {
    /// Samples a pixel.
    ///
    /// With `--time`, `--error`, `--pixel-error` or `--noise-threshold` and without `--samples`, these alone decide; of
    /// several, what is reached first.
    #[arg(long, value_name = "COUNT", whole = 1..=MAX_SAMPLES, preset = "256")]
    pub samples: Option<u32>,
    /// Be ready after this long, for example 30s, 2m or 1h.
    ///
    /// From the start of the program to the last file: loading, preparing and writing are counted.
    #[arg(long, value_name = "TIME", value_parser = values::duration)]
    pub time: Option<Duration>,
    /// Stop when the estimated error of the picture (see below) is not above this, for example 2%.
    ///
    /// It is looked at after 1, 2, 4, 8, 16, 32, 64, 128, 192, 256 … samples a pixel.
    #[arg(long, value_name = "TARGET", value_parser = values::share)]
    pub error: Option<f64>,
    /// Take samples where the estimated error of the pixel is above this, for example 5%, and stop when it is
    /// nowhere.
    ///
    /// Adaptive sampling: after 32 samples everywhere, where the error is largest first, so that it is even
    /// whenever the render ends. `--samples` is the most that a pixel gets. The errors of the pixels around a
    /// pixel, without its own, decide how many it gets: one that stopped when its own samples happen to agree would
    /// be too dark on average. So the target holds for the root mean square over 13 × 13 pixels; single details may
    /// be further off.
    #[arg(long, value_name = "TARGET", value_parser = values::share)]
    pub pixel_error: Option<f64>,
    /// Stop each pixel where Cycles' noise threshold stops it, for example 0.01: Cycles' own adaptive sampling, for the work
    /// that a file takes there.
    ///
    /// From `--min-samples` on it is looked every 16 samples how far half of a pixel's samples are from all of them, against the
    /// root of its brightness; pixels beside one that goes on go on with it. `--samples` is the most that a pixel
    /// gets. No share of the brightness as `--pixel-error` is, and a little too dark where light is rare: a pixel whose own
    /// samples happen to agree stops too soon.
    #[arg(long, value_name = "TARGET", value_parser = values::share, conflicts_with = "pixel_error")]
    pub noise_threshold: Option<f64>,
    /// With `--denoise`: stop when the denoised picture looks as near to the truth as this: mean FLIP as shown, for example 0.03.
    ///
    /// From 8 samples on both halves of the samples are denoised now and then, each by itself; FLIP between them says how far the
    /// denoised picture is from the truth. What the denoiser guesses wrong in both halves alike is in no difference between them:
    /// the factor that stands for it is a mean over scenes (docs/accuracy.md). 0.1 is plainly noisy, 0.02 hardly seen.
    #[arg(long, value_name = "TARGET", value_parser = values::share, requires = "denoise")]
    pub denoised_error: Option<f64>,
    /// With `--noise-threshold`: samples of each pixel before it may stop, as Cycles' Min Samples.
    ///
    /// If not given or 0, the threshold says it, as in Cycles: 64 for 0.01, and 32 for 0.1.
    #[arg(long, value_name = "COUNT", whole = 0..=MAX_SAMPLES, requires = "noise_threshold")]
    pub min_samples: Option<u32>,
    /// Take only the samples with the numbers from A to before B, for `sundog merge`.
    ///
    /// Several machines can share a picture: each renders a range of its own and keeps it with `--checkpoint`.
    #[arg(long, value_name = "A..B", value_parser = values::sample_range)]
    pub sample_range: Option<SampleRange>,
    /// Keep the state of the render here, and go on from it if it is there already.
    ///
    /// Written now and then and at the end, whatever ends the render. Going on gives the bits of a render that was
    /// never broken off, also with more `--samples` or another goal. If it cannot be written, a warning says so
    /// once, the render goes on and the picture is written; the exit code is 1 if the last state is not there.
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Time between two writings of the checkpoint, at least.
    #[arg(long, value_name = "TIME", value_parser = values::duration, default_value = "1m")]
    pub checkpoint_interval: Duration,
}

/// Render a scene.
///
/// The picture is written under each name given with -o: .exr keeps the linear light with all layers, .png and .jpg
/// are made with the display, view and look. Files are written beside and then renamed, so that a name never stands
/// for half a picture. What the scene itself wishes (SUNDOG_scene: size, filter width, transparent film;
/// configuration, display, view, look, exposure and gamma) holds where no flag says otherwise.
#[derive(Args, Clone, Debug)]
pub struct Render {
    #[command(flatten)]
    pub files: RenderFiles,
    #[command(flatten)]
    pub effort: RenderEffort,
    #[command(flatten)]
    pub passes: ChosenPasses,
    #[command(flatten)]
    pub denoising: Denoising,
    #[command(flatten)]
    pub effects: ChosenEffects,
    #[command(flatten)]
    pub options: RenderOptions,
    #[command(flatten, next_help_heading = "Display (PNG and JPEG)")]
    pub view: View,
    #[command(flatten)]
    pub exr: Exr,
    #[command(flatten)]
    pub reporting: Reporting,
}

/// Join parts of a render into one picture.
///
/// Each part is what `--checkpoint` of `sundog render` has written, of the same scene and settings, with a
/// `--sample-range` of its own. The picture has the bits of one that was rendered at once (passes of light apart:
/// but for the last bit of a sum in 64 bits), and its error is estimated from all samples.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Files")]
pub struct Merge {
    /// States of renders.
    #[arg(id = "PART", value_name = "PART", required = true)]
    pub part: Vec<PathBuf>,
    /// Where the picture goes: .exr, .png or .jpg; may be given more than once.
    ///
    /// At least one, or `--checkpoint`.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Keep the joined state here.
    ///
    /// It can be joined with more, or, if its samples are without gaps, be gone on with.
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    #[command(flatten)]
    pub denoising: Denoising,
    #[command(flatten, next_help_heading = "Display (PNG and JPEG)")]
    pub view: View,
    #[command(flatten)]
    pub exr: Exr,
    #[command(flatten)]
    pub reporting: Reporting,
}

/// Tell what is in a scene.
///
/// Cameras, lights, materials, triangles, instances, images, bounds, memory, what changes nothing and is left out,
/// the effects called for and by what, those that are not and why, and what is not supported.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Files")]
pub struct Info {
    /// The scene: a .glb or .gltf file as Blender exports it, or USD: .usda, .usdc, .usd, .usdz.
    #[arg(id = "SCENE", value_name = "SCENE")]
    pub scene: PathBuf,
    #[command(flatten)]
    pub import: Import,
    /// Tell it as one JSON object.
    #[arg(long, help_heading = "Messages")]
    pub json: bool,
}

/// What `sundog cost` is asked.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Question")]
pub struct CostQuestion {
    /// Measure what each effect of the scene costs, and the error that it removes.
    #[arg(long)]
    pub effects: bool,
    /// Samples a pixel of the picture that is asked about.
    #[arg(long, value_name = "COUNT", whole = 1..=MAX_SAMPLES, preset = "256")]
    pub samples: Option<u32>,
    /// Tell how long it takes until the error is this, for example 2%.
    #[arg(long, value_name = "GOAL", value_parser = values::share)]
    pub error: Option<f64>,
    /// With `--effects`: adaptive sampling to this error of each pixel, for example 5%.
    ///
    /// If not given, to the one that takes about as many samples as the picture has.
    #[arg(long, value_name = "TARGET", value_parser = values::share)]
    pub pixel_error: Option<f64>,
    /// Tell which error there will be after so long, for example 30s.
    ///
    /// Of tracing alone: loading, preparing and writing come on top.
    #[arg(long, value_name = "TIME", value_parser = values::duration)]
    pub time: Option<Duration>,
    /// How long is rendered to find out.
    ///
    /// 4s if not given; with `--effects` about so long for each picture, 1s if not given.
    #[arg(long, value_name = "TIME", value_parser = values::duration)]
    pub probe: Option<Duration>,
    /// With `--effects`: how often each picture is rendered, with a seed each.
    #[arg(long, value_name = "COUNT", whole = 3..=1_000, default_value = "3")]
    pub rounds: u32,
    /// With `--effects`: longer side of the pictures that are measured, at most.
    #[arg(long, value_name = "PIXELS", whole = 16..=MAX_SIDE, default_value = "256")]
    pub side: u32,
}

/// Tell what a picture costs: error and time ahead, or what each effect takes and gives.
///
/// A short probe renders the picture and forecasts which error (√relMSE) it has after which time, with 95 %
/// intervals, and answers `--error`, `--time` and `--samples`. If the probe comes to fewer than 16 samples at the
/// full size, it goes on at a reduced one. With `--effects`: the full picture and pictures that leave one thing out
/// each, in turns, at a reduced size; what an effect costs in milliseconds, scaled to the full picture, how far the
/// picture without it is from the full one (√relMSE, with the noise of both taken out by independent seeds), and
/// the most error removed for a second first. What it all means: docs/cost.md.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Files")]
pub struct Cost {
    /// The scene: a .glb or .gltf file as Blender exports it, or USD: .usda, .usdc, .usd, .usdz.
    #[arg(id = "SCENE", value_name = "SCENE")]
    pub scene: PathBuf,
    /// Where the numbers go: .json or .csv; may be given more than once.
    #[arg(short = 'o', long, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Write a page with curves and tables: .html.
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub question: CostQuestion,
    #[command(flatten)]
    pub passes: ChosenPasses,
    #[command(flatten)]
    pub options: RenderOptions,
    #[command(flatten, next_help_heading = "Display (report)")]
    pub seen: Seen,
    #[command(flatten)]
    pub reporting: Reporting,
}

/// Measure how far a picture is from a reference.
///
/// With x the picture and r the reference, means over pixels and channels: RMSE, the root of the mean of (x - r)²;
/// relMSE, (x - r)² / (r² + 0.01), and its root in percent; MAPE, |x - r| / (|r| + 0.01), and SMAPE, 2 |x - r| /
/// (|x| + |r| + 0.02), as the viewers tev and JERI have them; the ratio of mean luminances (Rec.709 weights). The
/// numbers of EXR files are compared as they are: linear light. Those of PNG files are display values 0..1. Then
/// how different they look: SSIM (Wang et al. 2004, as scikit-image computes it with Gaussian weights) and FLIP
/// (the mean of LDR-FLIP, Andersson et al. 2020, at 67 pixels a degree) of what one sees: PNG files as they are,
/// EXR files with the sRGB curve after clipping to 0..1 (which is Blender's "Standard" view on an sRGB display), or
/// by the display and view that the flags below choose; HDR-FLIP (Andersson et al. 2021, tone mapped by ACES,
/// exposures by the reference) of linear light. Nothing is rounded to 8 bits. Pixels in which a number is not
/// finite are counted and left out.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Files")]
pub struct Compare {
    /// The picture: .exr, .png or .jpg.
    #[arg(id = "A", value_name = "A")]
    pub a: PathBuf,
    /// The reference: .exr, .png or .jpg.
    #[arg(id = "B", value_name = "B")]
    pub b: PathBuf,
    /// Write the difference of each pixel as a heat map with a scale: .png.
    #[arg(long, value_name = "FILE")]
    pub difference_map: Option<PathBuf>,
    /// Write all of it as one page that needs no network: both pictures under a slider, heat maps, a histogram, the
    /// settings that the files tell: .html.
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Write the numbers as a table: .csv.
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// The layer of EXR files that is compared; the picture itself if not given.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    #[command(flatten, next_help_heading = "Display (SSIM and FLIP)")]
    pub seen: Seen,
    /// Tell it as one JSON object.
    #[arg(long, help_heading = "Messages")]
    pub json: bool,
}

/// How much `sundog converge` renders.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Effort")]
pub struct ConvergeEffort {
    /// Samples a pixel at the end of each run.
    #[arg(long, value_name = "COUNT", whole = 1..=MAX_SAMPLES, default_value = "256")]
    pub samples: u32,
    /// Runs, with a seed each.
    #[arg(long, value_name = "COUNT", whole = 1..=1_000, default_value = "3")]
    pub seeds: u32,
    /// Samples a pixel of each half of the reference; four times those of a run if not given.
    #[arg(long, value_name = "COUNT", whole = 1..=MAX_SAMPLES)]
    pub reference_samples: Option<u32>,
    /// What this renderer is called in tables and plots.
    #[arg(long, value_name = "NAME", default_value = "Sundog")]
    pub name: String,
}

/// Measure error against time, of this renderer and of others.
///
/// Renders the scene with several seeds, measures each picture after 1, 2, 4, 8 … samples against a reference, and
/// tells means and spreads, the fitted slope of log error against log time with its standard error, time × MSE, and
/// how much longer other renderers take to the same error. The measures are those of `sundog compare`; SSIM and
/// FLIP are of what one sees through the display and view. Without `--reference` the reference is rendered too: two
/// halves with seeds of their own, whose noise is taken out of RMSE and relMSE. What it all means, and the folder
/// of pictures that `--against` reads: docs/converge.md.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Files")]
pub struct Converge {
    /// The scene: a .glb or .gltf file as Blender exports it, or USD: .usda, .usdc, .usd, .usdz.
    #[arg(id = "SCENE", value_name = "SCENE")]
    pub scene: PathBuf,
    /// Where the answer goes: a folder for everything, or a file that ends in .html, .json, .csv, .svg or .png; may
    /// be given more than once.
    ///
    /// The table is shown on the terminal anyway.
    #[arg(short = 'o', long, value_name = "PATH")]
    pub output: Vec<PathBuf>,
    /// The truth: an EXR file; given twice, two whose noise is independent, so that it can be taken out.
    ///
    /// All renderers are measured against it then, also those whose folder has a reference of its own.
    #[arg(long, value_name = "FILE")]
    pub reference: Vec<PathBuf>,
    /// Pictures of other renderers with their times; may be given more than once.
    #[arg(long, value_name = "FOLDER")]
    pub against: Vec<PathBuf>,
    /// Keep each picture and its time there, as `--against` reads them.
    #[arg(long, value_name = "FOLDER")]
    pub pictures: Option<PathBuf>,
    #[command(flatten)]
    pub effort: ConvergeEffort,
    #[command(flatten)]
    pub effects: ChosenEffects,
    #[command(flatten)]
    pub options: RenderOptions,
    #[command(flatten, next_help_heading = "Display (SSIM and FLIP)")]
    pub seen: Seen,
    #[command(flatten)]
    pub reporting: Reporting,
}

/// List the displays, views, looks and colour spaces of the configuration.
#[derive(Args, Clone, Debug)]
pub struct ColorList {
    /// OpenColorIO configuration: a .ocio or .ocioz file, or an ocio:// name.
    ///
    /// If not given: `$OCIO`, an installed Blender or bpy, or else the configuration built into OpenColorIO.
    #[arg(long, value_name = "CONFIG", help_heading = "Configuration")]
    pub ocio: Option<String>,
    /// Tell it as one JSON object.
    #[arg(long, help_heading = "Messages")]
    pub json: bool,
}

/// Make a PNG or JPEG of linear light.
///
/// What `sundog render` does for its PNG and JPEG files, for a picture that is there already: Sundog's own EXR
/// files, those of Blender or other programs, Radiance HDR files. A PNG keeps alpha, unassociated; a JPEG shows the
/// picture on black.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Files")]
pub struct ColorApply {
    /// The picture: .exr or .hdr, linear Rec.709.
    #[arg(id = "IN", value_name = "IN")]
    pub input: PathBuf,
    /// Where the result goes: .png or .jpg.
    #[arg(id = "OUT", value_name = "OUT")]
    pub result: PathBuf,
    /// Layer of the EXR file, such as `Normal`; if not given, the picture itself.
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    #[command(flatten, next_help_heading = "Display (PNG and JPEG)")]
    pub view: View,
}

/// Try the hard cases of numerics on this machine, and show what came of each.
///
/// Each case has an answer that is known. The exit code is 1 if one is not met. What the cases are about, and where
/// their bounds come from, is told in docs/hard-cases.md.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Cases")]
pub struct SelfTest {
    /// This case alone.
    #[arg(long, value_name = "NAME")]
    pub case: Vec<String>,
    /// How much work they may take.
    #[arg(long, value_name = "EFFORT", value_parser = words(&EFFORTS), default_value = "quick")]
    pub effort: Effort,
    /// List the cases and run none.
    #[arg(long)]
    pub list: bool,
    /// Tell it as one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// List all commands and flags, for programs and for the documentation.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Format")]
pub struct Flags {
    /// As one JSON object (the default).
    #[arg(long)]
    pub json: bool,
    /// As docs/cli.md.
    #[arg(long)]
    pub markdown: bool,
    /// As a manual page.
    #[arg(long)]
    pub man: bool,
}

/// Write a completion script for a shell.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Shell")]
pub struct Completions {
    /// The shell.
    #[arg(id = "SHELL", value_name = "SHELL", value_parser = words(&SHELLS))]
    pub shell: Shell,
}

/// Show pictures through OpenColorIO.
#[derive(Subcommand, Clone, Debug)]
pub enum Color {
    List(ColorList),
    Apply(ColorApply),
}

/// A CPU path tracer for Blender scenes: glTF in, linear EXR and finished PNG or JPEG pictures out.
#[derive(Parser, Clone, Debug)]
#[command(name = "sundog", version, disable_help_subcommand = true, after_help = pages::examples())]
pub struct Program {
    #[command(subcommand)]
    pub command: Command,
}

/// All commands.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    Render(Box<Render>),
    Merge(Merge),
    Info(Info),
    Cost(Box<Cost>),
    Compare(Compare),
    Converge(Box<Converge>),
    #[command(subcommand, disable_help_subcommand = true)]
    Color(Color),
    #[command(name = "selftest")]
    SelfTest(SelfTest),
    Flags(Flags),
    Completions(Completions),
}
