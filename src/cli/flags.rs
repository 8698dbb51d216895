//! The one table of commands and flags: name, doc, default, range.
//!
//! The parser and its help ([`super::parser`]), `docs/cli.md`, the man page and the machine-readable
//! list ([`super::pages`]) come from it; nothing about a flag is written down a second time.

use serde::Serialize;

/// What kind of value an argument takes, with its range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Kind {
    /// No value: given or not.
    Switch,
    /// Any text.
    Text,
    /// A file or folder.
    Path,
    /// A whole number within bounds, both included.
    Integer {
        /// Smallest.
        min: u64,
        /// Largest.
        max: u64,
    },
    /// A finite number within bounds, both included.
    Number {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A length of time: `90`, `90s`, `1.5m`, `1h30m`.
    Duration,
    /// Three numbers of at least 0, `R,G,B`: linear Rec.709.
    Color,
    /// A pixel filter: `blackman-harris`, `gauss`, `box`, with `:WIDTH` in pixels after the first two.
    Filter,
    /// `auto`, `all`, or names of effects with commas between them.
    Effects,
    /// A share greater than 0, as a number or in percent.
    Share,
    /// `all`, or names of passes with commas between them.
    Passes,
    /// `on`, `off`, or a bounce from 1.
    Roulette,
    /// Where a program listens, `HOST:PORT` or `HOST` alone.
    Address {
        /// The port if none is given.
        port: u16,
    },
    /// Four whole numbers, `X0,Y0,X1,Y1`: a rectangle of pixels that is not empty.
    Region,
    /// Three whole numbers, `X,Y,SAMPLE`: a sample of a pixel.
    Sample,
    /// Two whole numbers, `A..B`: from A to before B.
    Range,
    /// One of a few words.
    Choice {
        /// The words.
        choices: &'static [Choice],
    },
}

/// One of the words that an argument accepts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// The word.
    pub name: &'static str,
    /// What it means.
    pub doc: &'static str,
}

/// A flag or a positional argument.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Argument {
    /// Long name without the dashes; of a positional argument, its name in messages.
    pub name: &'static str,
    /// Short name without the dash.
    pub short: Option<char>,
    /// Stands without a flag.
    pub positional: bool,
    /// What it takes.
    #[serde(flatten)]
    pub kind: Kind,
    /// Stands for the value in help.
    pub placeholder: &'static str,
    /// Must be given.
    pub required: bool,
    /// May be given more than once.
    pub repeats: bool,
    /// Value if it is not given, as one would write it.
    pub default: Option<&'static str>,
    /// What it does: one sentence.
    pub doc: &'static str,
    /// More about it; may be empty.
    pub details: &'static str,
}

impl Argument {
    const fn new(
        name: &'static str,
        kind: Kind,
        placeholder: &'static str,
        doc: &'static str,
    ) -> Self {
        Self {
            name,
            short: None,
            positional: false,
            kind,
            placeholder,
            required: false,
            repeats: false,
            default: None,
            doc,
            details: "",
        }
    }

    const fn switch(name: &'static str, doc: &'static str) -> Self {
        Self::new(name, Kind::Switch, "", doc)
    }

    const fn positional(
        name: &'static str,
        kind: Kind,
        placeholder: &'static str,
        doc: &'static str,
    ) -> Self {
        Self {
            positional: true,
            required: true,
            ..Self::new(name, kind, placeholder, doc)
        }
    }

    const fn short(self, short: char) -> Self {
        Self {
            short: Some(short),
            ..self
        }
    }

    const fn repeats(self) -> Self {
        Self {
            repeats: true,
            ..self
        }
    }

    const fn default(self, default: &'static str) -> Self {
        Self {
            default: Some(default),
            ..self
        }
    }

    const fn details(self, details: &'static str) -> Self {
        Self { details, ..self }
    }
}

/// Arguments under one heading.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Group {
    /// The heading.
    pub heading: &'static str,
    /// What stands under it.
    pub arguments: &'static [Argument],
}

/// A command or a command of a command.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Command {
    /// Its name.
    pub name: &'static str,
    /// What it does: one sentence.
    pub doc: &'static str,
    /// More about it; may be empty.
    pub details: &'static str,
    /// What it takes.
    pub groups: &'static [Group],
    /// Its own commands; empty for most.
    pub commands: &'static [Command],
}

/// What the process returns.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ExitCode {
    /// The code.
    pub code: u8,
    /// When.
    pub doc: &'static str,
}

/// Done.
pub const EXIT_OK: u8 = 0;
/// Could not do what was asked.
pub const EXIT_ERROR: u8 = 1;
/// Did not understand what was asked.
pub const EXIT_USAGE: u8 = 2;
/// Ended by Ctrl-C.
pub const EXIT_INTERRUPTED: u8 = 130;

/// All exit codes.
pub static EXIT_CODES: &[ExitCode] = &[
    ExitCode {
        code: EXIT_OK,
        doc: "Done.",
    },
    ExitCode {
        code: EXIT_ERROR,
        doc: "Something could not be done (a file cannot be read, a view does not exist, there is not enough memory, the standard output does not take what is written, …); one sentence on the standard error says what and how to go on.",
    },
    ExitCode {
        code: EXIT_USAGE,
        doc: "The command line could not be understood, or a file would be written over one that is read or over another one; nothing was done.",
    },
    ExitCode {
        code: EXIT_INTERRUPTED,
        doc: "Ended by Ctrl-C (or SIGTERM): `sundog render` has written the picture as far as it was; a second Ctrl-C ends at once and writes nothing. `cost` and `converge` end without an answer. All other commands end by the signal, and leave nothing half written.",
    },
];

/// What the program is.
pub const PROGRAM_DOC: &str = "A CPU path tracer for Blender scenes: glTF in, linear EXR and finished PNG or JPEG pictures out.";

/// Largest picture side.
pub const MAX_SIDE: u64 = 65_536;
/// Most bounces; Cycles has the same.
pub const MAX_BOUNCES: u64 = 1024;
/// Greatest film exposure: ten stops above Cycles' greatest.
pub const MAX_FILM_EXPOSURE: f64 = 10_240.0;
/// Most samples a pixel.
pub const MAX_SAMPLES: u64 = 1 << 20;

const IMPORT: Group = Group {
    heading: "Scene",
    arguments: &[
        Argument::new("scene", Kind::Text, "NAME|INDEX", "The glTF scene to load, where the file has more than one."),
        Argument::new(
            "light-units",
            Kind::Choice {
                choices: &[
                    Choice { name: "auto", doc: "\"standard\" or \"unitless\", by the program that wrote the file and by how bright its lamps come out; which, and why, is told" },
                    Choice { name: "standard", doc: "photometric, as KHR_lights_punctual has it: 683 lm are a watt" },
                    Choice { name: "unitless", doc: "radiometric: Blender's \"Unitless\"" },
                    Choice { name: "raw", doc: "Blender's own numbers: its \"Raw\"" },
                ],
            },
            "UNITS",
            "What the light intensities of the file mean: the \"Lighting Mode\" it was exported with.",
        )
        .default("auto"),
        Argument::new(
            "transmission",
            Kind::Choice {
                choices: &[
                    Choice { name: "auto", doc: "solid in files by Blender's exporter, thin otherwise" },
                    Choice { name: "solid", doc: "the surface bounds a solid and refracts" },
                    Choice { name: "thin", doc: "the surface is a thin sheet, as the extension says" },
                ],
            },
            "MEANING",
            "What glTF's transmission means where the file gives no thickness.",
        )
        .default("auto"),
        Argument::switch("allow-outside", "Read files that the scene names and that do not lie in its folder or below it.")
            .details("For scenes that you trust: an absolute path, `../` or a symbolic link in a file from elsewhere may lead to anything that you can read."),
        Argument::switch("strict", "Stop before rendering if anything in the scene is approximated or left out."),
    ],
};

const ENVIRONMENT: Group = Group {
    heading: "Environment",
    arguments: &[
        Argument::new(
            "environment",
            Kind::Path,
            "FILE",
            "Light from all around: an equirectangular picture, .exr or .hdr.",
        ),
        Argument::new(
            "environment-color",
            Kind::Color,
            "R,G,B",
            "Light from all around of one colour: radiance, linear Rec.709.",
        )
        .details("Not together with `--environment`."),
        Argument::new(
            "environment-strength",
            Kind::Number { min: 0.0, max: 1e9 },
            "FACTOR",
            "Multiplies the environment, as the strength of Blender's Background node does.",
        )
        .default("1"),
        Argument::new(
            "environment-rotation",
            Kind::Number { min: -1e6, max: 1e6 },
            "DEGREES",
            "Turns the environment about the up axis, in the sense of the Z rotation of Blender's Mapping node.",
        )
        .default("0"),
    ],
};

/// How pixels become display values; shared by all commands that write PNG or JPEG.
const VIEW: Group = Group {
    heading: "Display (PNG and JPEG)",
    arguments: &[
        Argument::new(
            "ocio",
            Kind::Text,
            "CONFIG",
            "OpenColorIO configuration: a .ocio or .ocioz file, or an ocio:// name.",
        )
        .details("If not given: `$OCIO`, an installed Blender or bpy, or else the configuration built into OpenColorIO."),
        Argument::new("display", Kind::Text, "NAME", "Display; the configuration's default if not given."),
        Argument::new("view", Kind::Text, "NAME", "View of the display, such as AgX, Filmic or Standard."),
        Argument::new("look", Kind::Text, "NAME", "Look on top of the view.")
            .details("One that goes with the view; `Punchy` is enough for `AgX - Punchy` with the view AgX, where no look has just the short name."),
        Argument::new(
            "exposure",
            Kind::Number { min: -32.0, max: 32.0 },
            "STOPS",
            "Exposure before the view: 1 doubles the light.",
        )
        .default("0"),
        Argument::new(
            "gamma",
            Kind::Number { min: 0.01, max: 100.0 },
            "GAMMA",
            "Gamma after the view: display values are raised to 1/GAMMA.",
        )
        .default("1"),
        Argument::new(
            "depth",
            Kind::Choice {
                choices: &[
                    Choice { name: "8", doc: "8 bits a channel" },
                    Choice { name: "16", doc: "16 bits a channel (PNG)" },
                ],
            },
            "BITS",
            "Bits a channel of PNG files.",
        )
        .default("8"),
        Argument::new("quality", Kind::Integer { min: 1, max: 100 }, "PERCENT", "Quality of JPEG files.")
            .default("90"),
    ],
};

const EXR: Group = Group {
    heading: "EXR",
    arguments: &[
        Argument::new(
            "exr-type",
            Kind::Choice {
                choices: &[
                    Choice { name: "float", doc: "32 bits" },
                    Choice {
                        name: "half",
                        doc: "16 bits; depth, position and sample count stay at 32, values above 65504 become 65504",
                    },
                ],
            },
            "TYPE",
            "Number format of EXR files.",
        )
        .default("float"),
        Argument::new(
            "exr-compression",
            Kind::Choice {
                choices: &[
                    Choice { name: "zip", doc: "lossless, 16 lines at a time" },
                    Choice { name: "zips", doc: "lossless, line by line" },
                    Choice { name: "piz", doc: "lossless, wavelets: good for noisy pictures" },
                    Choice { name: "rle", doc: "lossless, quick" },
                    Choice { name: "none", doc: "as it is" },
                ],
            },
            "METHOD",
            "Compression of EXR files.",
        )
        .default("zip"),
        Argument::new(
            "exr-layers",
            Kind::Choice {
                choices: &[
                    Choice { name: "all", doc: "those that `--passes` names" },
                    Choice { name: "combined", doc: "the picture alone, which Blender then reads as a plain image" },
                ],
            },
            "LAYERS",
            "Which layers EXR files have.",
        )
        .default("all"),
    ],
};

/// A limit for bounces of one kind.
const fn limit(name: &'static str, doc: &'static str) -> Argument {
    Argument::new(
        name,
        Kind::Integer {
            min: 0,
            max: MAX_BOUNCES,
        },
        "COUNT",
        doc,
    )
    .details("No limit if not given.")
}

const REPORTING: Group = Group {
    heading: "Messages",
    arguments: &[
        Argument::switch("quiet", "Say nothing but errors.").short('q'),
        Argument::switch(
            "json",
            "Tell what happens on the standard output, one JSON object a line.",
        ),
    ],
};

const SCENE_FILE: Argument = Argument::positional(
    "SCENE",
    Kind::Path,
    "SCENE",
    "The scene: a .glb or .gltf file, as Blender exports it.",
);

/// What of the scene is pictured, and how large; shared by all commands that render.
const PICTURE: Group = Group {
    heading: "Picture",
    arguments: &[
        Argument::new("width", Kind::Integer { min: 1, max: MAX_SIDE }, "PIXELS", "Pixels a row.").details(
            "If only one of width and height is given, the other follows from the camera's aspect; if none is, the scene's own size holds (SUNDOG_scene), or else the longer side has 1280 pixels.",
        ),
        Argument::new("height", Kind::Integer { min: 1, max: MAX_SIDE }, "PIXELS", "Rows."),
        Argument::new(
            "region",
            Kind::Region,
            "X0,Y0,X1,Y1",
            "Render only these pixels of the picture: from the column X0 and the row Y0, counted from the top left, up to and without X1 and Y1.",
        )
        .details("The files hold these pixels alone. They are the same, bit for bit, as in the full picture."),
        Argument::new(
            "camera",
            Kind::Text,
            "NAME|INDEX",
            "The camera, by name or by number from 0; the first one if not given.",
        ),
        Argument::switch(
            "transparent",
            "Leave the world out of the picture: where the camera looks straight at it (or through alpha), alpha is 0.",
        ),
        Argument::new(
            "film-exposure",
            Kind::Number { min: 0.0, max: MAX_FILM_EXPOSURE },
            "FACTOR",
            "Factor on all light of the picture, as Cycles' film exposure; the scene's if not given.",
        )
        .default("1")
        .details("Combined and the passes of light are scaled; what surfaces are like (colours, albedo, normals, depth) is not. Not the exposure of the view, which --exposure is."),
        Argument::new(
            "passes",
            Kind::Passes,
            "LIST",
            "Which passes the last frame and EXR files have, by Blender's names with commas between them; `all` for all.",
        )
        .default("Combined,Depth,Normal,Position,Denoising Albedo,Debug Sample Count,Error")
        .details("Combined is always among them. What each of them holds stands below."),
        Argument::new("filter", Kind::Filter, "FILTER[:WIDTH]", "Pixel filter and its width in pixels, as Blender counts it.")
            .default("blackman-harris:1.5")
            .details("One of blackman-harris, gauss and box; the box is one pixel wide. blackman-harris reaches as far as its width from the middle of the pixel; gauss has a standard deviation of a quarter of its width. If not given: the scene's own width (SUNDOG_scene)."),
    ],
};

/// How long paths may be; shared by all commands that render.
const BOUNCES: Group = Group {
    heading: "Bounces",
    arguments: &[
        Argument::new(
            "bounces",
            Kind::Integer {
                min: 0,
                max: MAX_BOUNCES,
            },
            "COUNT",
            "Bounces of a path, as Cycles counts its Max Bounces: 0 is direct light alone.",
        )
        .default("12"),
        limit(
            "bounces-diffuse",
            "Diffuse reflections of a path, as Cycles counts its Max Bounces for Diffuse.",
        ),
        limit(
            "bounces-glossy",
            "The same for glossy reflections, mirrors included.",
        ),
        limit(
            "bounces-transmission",
            "The same for passages through glass: a solid takes two.",
        ),
        limit(
            "bounces-transparent",
            "Surfaces that a path may pass by their opacity, and a shadow ray from its end, as Cycles counts them: they are no bounces.",
        ),
    ],
};

/// How light is simulated; shared by all commands that render.
const TRANSPORT: Group = Group {
    heading: "Light transport",
    arguments: &[
        Argument::new("effects", Kind::Effects, "auto|all|LIST", "Which effects are simulated.")
            .default("auto")
            .details(
                "`auto` takes what the scene calls for, `all` everything there is; a list of names with commas between them takes these and leaves out what the scene calls for beyond them, which is told once and written into the picture (docs/effects.md).",
            ),
        Argument::new(
            "clamp-direct",
            Kind::Number { min: 0.0, max: 1e9 },
            "VALUE",
            "Greatest value (mean of the channels) of one contribution of direct light, and of what the camera sees itself; 0 for no limit.",
        )
        .default("0")
        .details("Biased: takes light away, as Cycles' Clamp Direct does. How much is told at the end."),
        Argument::new(
            "clamp-indirect",
            Kind::Number { min: 0.0, max: 1e9 },
            "VALUE",
            "The same for indirect light; 0 for no limit.",
        )
        .default("0")
        .details("Biased: takes light away, above all caustics, as Cycles' Clamp Indirect does, which is 10 by default there. How much is told at the end."),
        Argument::new(
            "filter-glossy",
            Kind::Number { min: 0.0, max: 1e6 },
            "VALUE",
            "Makes reflection and refraction rougher behind blurring bounces, as Cycles' Filter Glossy; 0 for off.",
        )
        .default("0")
        .details("Biased: caustics get soft. Cycles has 1 by default."),
        Argument::new(
            "caustics",
            Kind::Choice {
                choices: &[
                    Choice { name: "all", doc: "as light does" },
                    Choice { name: "reflective", doc: "no caustics through glass" },
                    Choice { name: "refractive", doc: "no caustics of reflections" },
                    Choice { name: "none", doc: "neither" },
                ],
            },
            "KINDS",
            "Which caustics there are: what reflects or lets through where a path comes to it from a diffuse reflection.",
        )
        .default("all")
        .details("Biased: all but `all` take light away, as Cycles' switches of the same names do."),
        Argument::switch(
            "backface-culling",
            "Hide the back faces of single-sided materials, as glTF viewers do and Cycles does not.",
        ),
    ],
};

/// How light is looked for; shared by all commands that render.
const STUDIES: Group = Group {
    heading: "Studies",
    arguments: &[
        Argument::new(
            "light-sampling",
            Kind::Choice {
                choices: &[
                    Choice { name: "mis", doc: "light sampling and BSDF sampling, weighted by multiple importance sampling" },
                    Choice { name: "nee", doc: "light sampling (next-event estimation) wherever it can find the light" },
                    Choice { name: "bsdf", doc: "BSDF sampling wherever it can find the light" },
                    Choice { name: "hemisphere", doc: "directions drawn uniformly, whatever the surface, wherever these can find the light" },
                ],
            },
            "TECHNIQUE",
            "How paths find light; mis is the one to use, the others show why.",
        )
        .default("mis")
        .details("All have the same picture in the mean."),
        Argument::new(
            "light-samples",
            Kind::Integer { min: 1, max: crate::render::MAX_LIGHT_SAMPLES as u64 },
            "COUNT",
            "Light samples at the surface that the camera sees, of which the mean counts; at all others it is one.",
        )
        .default("1")
        .details("The same picture in the mean."),
        Argument::new(
            "roulette",
            Kind::Roulette,
            "on|off|BOUNCE",
            "From which bounce on paths that carry little light may end by chance; `on` is 2, `off` follows each to its last bounce.",
        )
        .default("on")
        .details("The same picture in the mean."),
        Argument::new(
            "naive",
            Kind::Choice {
                choices: &[
                    Choice { name: "offsets", doc: "rays start a ten-thousandth of a metre off surfaces, instead of by derived error bounds" },
                    Choice { name: "edges", doc: "triangles are met by Embree's fast test, which lets rays through at edges" },
                    Choice { name: "origin", doc: "positions become single-precision numbers where they are, instead of relative to the camera" },
                    Choice { name: "terminator", doc: "directions below a triangle are lost, although the smooth surface that it stands for sees them" },
                ],
            },
            "PART",
            "Leave out something that keeps pictures stable, to see what it is good for and what it costs.",
        )
        .repeats()
        .details("Pictures get wrong: docs/hard-cases.md shows how."),
    ],
};

const THREADS: Argument = Argument::new(
    "threads",
    Kind::Integer { min: 1, max: 1024 },
    "COUNT",
    "Threads; all the processor has if not given.",
)
.details("The picture does not depend on it.");

const INSTRUCTIONS: Argument = Argument::new(
    "instruction-set",
    Kind::Choice {
        choices: &[
            Choice { name: "avx2", doc: "most processors since 2013; what is taken where the processor has it" },
            Choice { name: "sse4.2", doc: "all processors since 2011; what is taken elsewhere" },
        ],
    },
    "NAME",
    "Instructions by which rays meet surfaces.",
)
.details("The last bits of the picture depend on it, so that machines that share a picture need the same: ask for sse4.2 where one of them lacks AVX2. Better instructions of a newer processor are not taken. The variable `SUNDOG_INSTRUCTION_SET` asks for it where no flag does.");

const SEED: Argument = Argument::new(
    "seed",
    Kind::Integer {
        min: 0,
        max: u32::MAX as u64,
    },
    "NUMBER",
    "Selects another independent random sequence.",
)
.default("0");

static RENDER: Command = Command {
    name: "render",
    doc: "Render a scene.",
    details: "The picture is written under each name given with -o: .exr keeps the linear light with all layers, .png and .jpg are made with the display, view and look. Files are written beside and then renamed, so that a name never stands for half a picture. What the scene itself wishes (SUNDOG_scene: size, filter width, transparent film; configuration, display, view, look, exposure and gamma) holds where no flag says otherwise.",
    groups: &[
        Group {
            heading: "Files",
            arguments: &[
                SCENE_FILE,
                Argument::new(
                    "output",
                    Kind::Path,
                    "FILE",
                    "Where the picture goes: .exr, .png or .jpg; may be given more than once.",
                )
                .short('o')
                .repeats()
                .details("At least one, or `--frames` or `--checkpoint`."),
                Argument::new(
                    "frames",
                    Kind::Path,
                    "FOLDER",
                    "Write the picture as raw floats while it grows, for programs: see below; needs `--json`.",
                ),
                Argument::new(
                    "tev",
                    Kind::Address { port: crate::output::tev::PORT },
                    "HOST[:PORT]",
                    "Show the picture while it grows in the image viewer tev that listens there.",
                )
                .details("Under the name of the first file, a few times a second; all passes at the end. If nobody listens, or no longer, a warning says so and the render goes on."),
                Argument::new(
                    "replay",
                    Kind::Sample,
                    "X,Y,SAMPLE",
                    "Instead of a picture: print the path of one of its samples, vertex by vertex, with all densities and weights.",
                )
                .details("Column and row from the top left, both from 0, and the number of the sample, as a render names those that were not finite. All other flags have to be those of the render. With `--json` as one object."),
            ],
        },
        PICTURE,
        Group {
            heading: "Effort",
            arguments: &[
                Argument::new("samples", Kind::Integer { min: 1, max: MAX_SAMPLES }, "COUNT", "Samples a pixel.")
                    .default("256")
                    .details("With `--time`, `--error` or `--pixel-error` and without `--samples`, these alone decide; of several, what is reached first."),
                Argument::new("time", Kind::Duration, "TIME", "Be ready after this long, for example 30s, 2m or 1h.")
                    .details("From the start of the program to the last file: loading, preparing and writing are counted."),
                Argument::new("error", Kind::Share, "TARGET", "Stop when the estimated error of the picture (see below) is not above this, for example 2%.")
                    .details("It is looked at after 1, 2, 4, 8, 16, 32, 64, 128, 192, 256 … samples a pixel."),
                Argument::new("pixel-error", Kind::Share, "TARGET", "Take samples where the estimated error of the pixel is above this, for example 5%, and stop when it is nowhere.")
                    .details("Adaptive sampling: after 32 samples everywhere, where the error is largest first, so that it is even whenever the render ends. `--samples` is the most that a pixel gets. The errors of the pixels around a pixel, without its own, decide how many it gets: one that stopped when its own samples happen to agree would be too dark on average. So the target holds for the root mean square over 13 × 13 pixels; single details may be further off."),
                Argument::new("sample-range", Kind::Range, "A..B", "Take only the samples with the numbers from A to before B, for `sundog merge`.")
                    .details("Several machines can share a picture: each renders a range of its own and keeps it with `--checkpoint`."),
                Argument::new("checkpoint", Kind::Path, "FILE", "Keep the state of the render here, and go on from it if it is there already.")
                    .details("Written now and then and at the end, whatever ends the render. Going on gives the bits of a render that was never broken off, also with more `--samples` or another goal. If it cannot be written, a warning says so once, the render goes on and the picture is written; the exit code is 1 if the last state is not there."),
                Argument::new("checkpoint-interval", Kind::Duration, "TIME", "Time between two writings of the checkpoint, at least.")
                    .default("1m"),
                THREADS,
                INSTRUCTIONS,
                SEED,
            ],
        },
        BOUNCES,
        TRANSPORT,
        STUDIES,
        IMPORT,
        ENVIRONMENT,
        VIEW,
        EXR,
        REPORTING,
    ],
    commands: &[],
};

static MERGE: Command = Command {
    name: "merge",
    doc: "Join parts of a render into one picture.",
    details: "Each part is what `--checkpoint` of `sundog render` has written, of the same scene and settings, with a `--sample-range` of its own. The picture has the bits of one that was rendered at once (passes of light apart: but for the last bit of a sum in 64 bits), and its error is estimated from all samples.",
    groups: &[
        Group {
            heading: "Files",
            arguments: &[
                Argument::positional("PART", Kind::Path, "PART", "States of renders.").repeats(),
                Argument::new(
                    "output",
                    Kind::Path,
                    "FILE",
                    "Where the picture goes: .exr, .png or .jpg; may be given more than once.",
                )
                .short('o')
                .repeats()
                .details("At least one, or `--checkpoint`."),
                Argument::new("checkpoint", Kind::Path, "FILE", "Keep the joined state here.")
                    .details("It can be joined with more, or, if its samples are without gaps, be gone on with."),
            ],
        },
        VIEW,
        EXR,
        REPORTING,
    ],
    commands: &[],
};

static INFO: Command = Command {
    name: "info",
    doc: "Tell what is in a scene.",
    details: "Cameras, lights, materials, triangles, instances, images, bounds, memory, what changes nothing and is left out, the effects called for and by what, those that are not and why, and what is not supported.",
    groups: &[
        Group {
            heading: "Files",
            arguments: &[SCENE_FILE],
        },
        IMPORT_INFO,
        Group {
            heading: "Messages",
            arguments: &[Argument::switch("json", "Tell it as one JSON object.")],
        },
    ],
    commands: &[],
};

/// As `IMPORT`, without what only matters before a render.
const IMPORT_INFO: Group = Group {
    heading: "Scene",
    arguments: &[
        IMPORT.arguments[0],
        IMPORT.arguments[1],
        IMPORT.arguments[2],
        IMPORT.arguments[3],
    ],
};

/// What is seen of linear light when pictures are measured; as `VIEW`, without what only files have.
const SEEN: Group = Group {
    heading: "Display (SSIM and FLIP)",
    arguments: &[
        VIEW.arguments[0],
        VIEW.arguments[1],
        VIEW.arguments[2],
        VIEW.arguments[3],
        VIEW.arguments[4],
        VIEW.arguments[5],
    ],
};

/// As `TRANSPORT`, without the choice of effects: what is measured are those that the scene calls for.
const TRANSPORT_COST: Group = Group {
    heading: "Light transport",
    arguments: TRANSPORT.arguments.split_at(1).1,
};

/// How a report shows pictures; as `VIEW`, without what only files have.
const SHOWN: Group = Group {
    heading: "Display (report)",
    arguments: SEEN.arguments,
};

static COST: Command = Command {
    name: "cost",
    doc: "Tell what a picture costs: error and time ahead, or what each effect takes and gives.",
    details: "A short probe renders the picture and forecasts which error (√relMSE) it has after which time, with 95 % intervals, and answers `--error`, `--time` and `--samples`. If the probe comes to fewer than 16 samples at the full size, it goes on at a reduced one. With `--effects`: the full picture and pictures that leave one thing out each, in turns, at a reduced size; what an effect costs in milliseconds, scaled to the full picture, how far the picture without it is from the full one (√relMSE, with the noise of both taken out by independent seeds), and the most error removed for a second first. What it all means: docs/cost.md.",
    groups: &[
        Group {
            heading: "Files",
            arguments: &[
                SCENE_FILE,
                Argument::new(
                    "output",
                    Kind::Path,
                    "FILE",
                    "Where the numbers go: .json or .csv; may be given more than once.",
                )
                .short('o')
                .repeats(),
                Argument::new(
                    "report",
                    Kind::Path,
                    "FILE",
                    "Write a page with curves and tables: .html.",
                ),
            ],
        },
        Group {
            heading: "Question",
            arguments: &[
                Argument::switch(
                    "effects",
                    "Measure what each effect of the scene costs, and the error that it removes.",
                ),
                Argument::new(
                    "samples",
                    Kind::Integer {
                        min: 1,
                        max: MAX_SAMPLES,
                    },
                    "COUNT",
                    "Samples a pixel of the picture that is asked about.",
                )
                .default("256"),
                Argument::new("error", Kind::Share, "GOAL", "Tell how long it takes until the error is this, for example 2%."),
                Argument::new("pixel-error", Kind::Share, "TARGET", "With `--effects`: adaptive sampling to this error of each pixel, for example 5%.")
                    .details("If not given, to the one that takes about as many samples as the picture has."),
                Argument::new("time", Kind::Duration, "TIME", "Tell which error there will be after so long, for example 30s.")
                    .details("Of tracing alone: loading, preparing and writing come on top."),
                Argument::new(
                    "probe",
                    Kind::Duration,
                    "TIME",
                    "How long is rendered to find out.",
                )
                .details("4s if not given; with `--effects` about so long for each picture, 1s if not given."),
                Argument::new(
                    "rounds",
                    Kind::Integer { min: 3, max: 1000 },
                    "COUNT",
                    "With `--effects`: how often each picture is rendered, with a seed each.",
                )
                .default("3"),
                Argument::new(
                    "side",
                    Kind::Integer {
                        min: 16,
                        max: MAX_SIDE,
                    },
                    "PIXELS",
                    "With `--effects`: longer side of the pictures that are measured, at most.",
                )
                .default("256"),
                THREADS,
                INSTRUCTIONS,
                SEED,
            ],
        },
        PICTURE,
        BOUNCES,
        TRANSPORT_COST,
        STUDIES,
        IMPORT,
        ENVIRONMENT,
        SHOWN,
        REPORTING,
    ],
    commands: &[],
};

static COMPARE: Command = Command {
    name: "compare",
    doc: "Measure how far a picture is from a reference.",
    details: "With x the picture and r the reference, means over pixels and channels: RMSE, the root of the mean of (x - r)²; relMSE, (x - r)² / (r² + 0.01), and its root in percent; MAPE, |x - r| / (|r| + 0.01), and SMAPE, 2 |x - r| / (|x| + |r| + 0.02), as the viewers tev and JERI have them; the ratio of mean luminances (Rec.709 weights). The numbers of EXR files are compared as they are: linear light. Those of PNG files are display values 0..1. Then how different they look: SSIM (Wang et al. 2004, as scikit-image computes it with Gaussian weights) and FLIP (the mean of LDR-FLIP, Andersson et al. 2020, at 67 pixels a degree) of what one sees: PNG files as they are, EXR files with the sRGB curve after clipping to 0..1 (which is Blender's \"Standard\" view on an sRGB display), or by the display and view that the flags below choose; HDR-FLIP (Andersson et al. 2021, tone mapped by ACES, exposures by the reference) of linear light. Nothing is rounded to 8 bits. Pixels in which a number is not finite are counted and left out.",
    groups: &[
        Group {
            heading: "Files",
            arguments: &[
                Argument::positional("A", Kind::Path, "A", "The picture: .exr, .png or .jpg."),
                Argument::positional("B", Kind::Path, "B", "The reference: .exr, .png or .jpg."),
                Argument::new(
                    "difference-map",
                    Kind::Path,
                    "FILE",
                    "Write the difference of each pixel as a heat map with a scale: .png.",
                ),
                Argument::new(
                    "report",
                    Kind::Path,
                    "FILE",
                    "Write all of it as one page that needs no network: both pictures under a slider, heat maps, a histogram, the settings that the files tell: .html.",
                ),
                Argument::new(
                    "csv",
                    Kind::Path,
                    "FILE",
                    "Write the numbers as a table: .csv.",
                ),
                Argument::new(
                    "layer",
                    Kind::Text,
                    "NAME",
                    "The layer of EXR files that is compared; the picture itself if not given.",
                ),
            ],
        },
        SEEN,
        Group {
            heading: "Messages",
            arguments: &[Argument::switch("json", "Tell it as one JSON object.")],
        },
    ],
    commands: &[],
};

static CONVERGE: Command = Command {
    name: "converge",
    doc: "Measure error against time, of this renderer and of others.",
    details: "Renders the scene with several seeds, measures each picture after 1, 2, 4, 8 … samples against a reference, and tells means and spreads, the fitted slope of log error against log time with its standard error, time × MSE, and how much longer other renderers take to the same error. The measures are those of `sundog compare`; SSIM and FLIP are of what one sees through the display and view. Without `--reference` the reference is rendered too: two halves with seeds of their own, whose noise is taken out of RMSE and relMSE. What it all means, and the folder of pictures that `--against` reads: docs/converge.md.",
    groups: &[
        Group {
            heading: "Files",
            arguments: &[
                SCENE_FILE,
                Argument::new(
                    "output",
                    Kind::Path,
                    "PATH",
                    "Where the answer goes: a folder for everything, or a file that ends in .html, .json, .csv, .svg or .png; may be given more than once.",
                )
                .short('o')
                .repeats()
                .details("The table is shown on the terminal anyway."),
                Argument::new(
                    "reference",
                    Kind::Path,
                    "FILE",
                    "The truth: an EXR file; given twice, two whose noise is independent, so that it can be taken out.",
                )
                .repeats()
                .details("All renderers are measured against it then, also those whose folder has a reference of its own."),
                Argument::new(
                    "against",
                    Kind::Path,
                    "FOLDER",
                    "Pictures of other renderers with their times; may be given more than once.",
                )
                .repeats(),
                Argument::new(
                    "pictures",
                    Kind::Path,
                    "FOLDER",
                    "Keep each picture and its time there, as `--against` reads them.",
                ),
            ],
        },
        Group {
            heading: "Effort",
            arguments: &[
                Argument::new(
                    "samples",
                    Kind::Integer {
                        min: 1,
                        max: MAX_SAMPLES,
                    },
                    "COUNT",
                    "Samples a pixel at the end of each run.",
                )
                .default("256"),
                Argument::new("seeds", Kind::Integer { min: 1, max: 1000 }, "COUNT", "Runs, with a seed each.")
                    .default("3"),
                SEED,
                Argument::new(
                    "reference-samples",
                    Kind::Integer {
                        min: 1,
                        max: MAX_SAMPLES,
                    },
                    "COUNT",
                    "Samples a pixel of each half of the reference; four times those of a run if not given.",
                ),
                THREADS,
                INSTRUCTIONS,
                Argument::new("name", Kind::Text, "NAME", "What this renderer is called in tables and plots.")
                    .default("Sundog"),
            ],
        },
        SIZE,
        BOUNCES,
        TRANSPORT,
        STUDIES,
        IMPORT,
        ENVIRONMENT,
        SEEN,
        REPORTING,
    ],
    commands: &[],
};

/// The picture of a command that measures it; as `PICTURE`, without what only files have.
const SIZE: Group = Group {
    heading: "Picture",
    arguments: &[
        PICTURE.arguments[0],
        PICTURE.arguments[1],
        PICTURE.arguments[2],
        PICTURE.arguments[3],
        PICTURE.arguments[4],
        PICTURE.arguments[5],
        PICTURE.arguments[7],
    ],
};

static SELFTEST: Command = Command {
    name: "selftest",
    doc: "Try the hard cases of numerics on this machine, and show what came of each.",
    details: "Each case has an answer that is known. The exit code is 1 if one is not met. What the cases are about, and where their bounds come from, is told in docs/hard-cases.md.",
    groups: &[Group {
        heading: "Cases",
        arguments: &[
            Argument::new("case", Kind::Text, "NAME", "This case alone.").repeats(),
            Argument::new(
                "effort",
                Kind::Choice {
                    choices: &[
                        Choice {
                            name: "quick",
                            doc: "a second or less for each case",
                        },
                        Choice {
                            name: "thorough",
                            doc: "some seconds: what the project's own tests do",
                        },
                        Choice {
                            name: "long",
                            doc: "minutes",
                        },
                    ],
                },
                "EFFORT",
                "How much work they may take.",
            )
            .default("quick"),
            Argument::switch("list", "List the cases and run none."),
            Argument::switch("json", "Tell it as one JSON object."),
        ],
    }],
    commands: &[],
};

static FLAGS: Command = Command {
    name: "flags",
    doc: "List all commands and flags, for programs and for the documentation.",
    details: "",
    groups: &[Group {
        heading: "Format",
        arguments: &[
            Argument::switch("json", "As one JSON object (the default)."),
            Argument::switch("markdown", "As docs/cli.md."),
            Argument::switch("man", "As a manual page."),
        ],
    }],
    commands: &[],
};

static COMPLETIONS: Command = Command {
    name: "completions",
    doc: "Write a completion script for a shell.",
    details: "",
    groups: &[Group {
        heading: "Shell",
        arguments: &[Argument::positional(
            "SHELL",
            Kind::Choice {
                choices: &[
                    Choice {
                        name: "bash",
                        doc: "Bash",
                    },
                    Choice {
                        name: "elvish",
                        doc: "Elvish",
                    },
                    Choice {
                        name: "fish",
                        doc: "fish",
                    },
                    Choice {
                        name: "powershell",
                        doc: "PowerShell",
                    },
                    Choice {
                        name: "zsh",
                        doc: "Z shell",
                    },
                ],
            },
            "SHELL",
            "The shell.",
        )],
    }],
    commands: &[],
};

static COLOR: Command = Command {
    name: "color",
    doc: "Show pictures through OpenColorIO.",
    details: "",
    groups: &[],
    commands: &[
        Command {
            name: "list",
            doc: "List the displays, views, looks and colour spaces of the configuration.",
            details: "",
            groups: &[
                Group {
                    heading: "Configuration",
                    arguments: &[VIEW.arguments[0]],
                },
                Group {
                    heading: "Messages",
                    arguments: &[Argument::switch("json", "Tell it as one JSON object.")],
                },
            ],
            commands: &[],
        },
        Command {
            name: "apply",
            doc: "Make a PNG or JPEG of linear light.",
            details: "What `sundog render` does for its PNG and JPEG files, for a picture that is there already: Sundog's own EXR files, those of Blender or other programs, Radiance HDR files. A PNG keeps alpha, unassociated; a JPEG shows the picture on black.",
            groups: &[
                Group {
                    heading: "Files",
                    arguments: &[
                        Argument::positional(
                            "IN",
                            Kind::Path,
                            "IN",
                            "The picture: .exr or .hdr, linear Rec.709.",
                        ),
                        Argument::positional(
                            "OUT",
                            Kind::Path,
                            "OUT",
                            "Where the result goes: .png or .jpg.",
                        ),
                        Argument::new(
                            "layer",
                            Kind::Text,
                            "NAME",
                            "Layer of the EXR file, such as `Normal`; if not given, the picture itself.",
                        ),
                    ],
                },
                VIEW,
            ],
            commands: &[],
        },
    ],
};

/// All commands.
pub static COMMANDS: &[&Command] = &[
    &RENDER,
    &MERGE,
    &INFO,
    &COST,
    &COMPARE,
    &CONVERGE,
    &COLOR,
    &SELFTEST,
    &FLAGS,
    &COMPLETIONS,
];

/// Examples that stand at the end of the help.
pub static EXAMPLES: &[(&str, &str)] = &[
    (
        "sundog render scene.glb -o shot.exr -o shot.png",
        "Render, keep the linear light and a finished picture.",
    ),
    (
        "sundog render scene.glb -o shot.exr --time 2m",
        "As many samples as two minutes allow.",
    ),
    (
        "sundog render scene.glb -o shot.exr --pixel-error 5%",
        "As many samples as it takes until no part of the picture is more than 5 % wrong.",
    ),
    (
        "sundog render scene.glb -o shot.png --environment sky.hdr --view AgX",
        "Light from a picture of the sky.",
    ),
    (
        "sundog info scene.glb",
        "What is in the scene, and what could not be carried over.",
    ),
    (
        "sundog compare shot.exr reference.exr",
        "How far the picture is from another one.",
    ),
    (
        "sundog converge scene.glb -o report",
        "Error against time, as a page with curves.",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(command: &'static Command, check: &mut dyn FnMut(&'static Command, &'static Argument)) {
        for argument in command.groups.iter().flat_map(|g| g.arguments) {
            check(command, argument);
        }
        for inner in command.commands {
            walk(inner, check);
        }
    }

    #[test]
    fn docs_are_sentences_and_names_are_unique() {
        for command in COMMANDS {
            let mut seen = std::collections::HashSet::new();
            walk(command, &mut |command, argument| {
                assert!(
                    seen.insert((command.name, argument.name)),
                    "{} {}",
                    command.name,
                    argument.name
                );
                assert!(argument.doc.ends_with('.'), "{}", argument.doc);
                assert!(
                    !argument.required || argument.default.is_none(),
                    "{}",
                    argument.name
                );
                let upper = argument.name.chars().all(|c| c.is_ascii_uppercase());
                assert_eq!(argument.positional, upper, "{}", argument.name);
            });
        }
    }

    #[test]
    fn defaults_pass_their_own_ranges() {
        for command in COMMANDS {
            walk(command, &mut |_, argument| {
                if let Some(default) = argument.default {
                    let value = crate::cli::values::parse(&argument.kind, default.as_ref());
                    assert!(value.is_ok(), "{}: {value:?}", argument.name);
                }
            });
        }
    }
}
