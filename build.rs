//! Finds Embree, OpenColorIO and libclang, makes the Rust bindings, and compiles the C++ shim over OpenColorIO.
//!
//! Each library is looked for in this order: the environment variable (`EMBREE_DIR`, `OCIO_DIR`, `LIBCLANG_PATH`; the
//! first two take a prefix or the word `system`), the project's own prefix `.native/` (made by `make setup`), the system.
//!
//! For the crate it writes `OUT_DIR/embree.rs`, `OUT_DIR/ocio.rs` and `OUT_DIR/double.rs`, and sets `SUNDOG_EMBREE_HEADERS` and
//! `SUNDOG_OCIO_HEADERS` (versions of the headers that were read, as `4.3.3`; for `env!`).

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// The oldest Embree whose hit structures have the fields that the bindings name (instance arrays came with 4.3).
const EMBREE_AT_LEAST: [u32; 3] = [4, 3, 0];
/// The oldest OpenColorIO that reads Blender 5.0's configuration (its profile is 2.4).
const OCIO_AT_LEAST: [u32; 3] = [2, 4, 0];

/// Where a library's headers and shared object are.
struct Library {
    include: PathBuf,
    /// `None`: where the linker looks anyway.
    lib: Option<PathBuf>,
}

/// What is looked for, and what to tell the person if it isn't there.
struct Wanted {
    name: &'static str,
    variable: &'static str,
    /// A header, relative to the include folder.
    header: &'static str,
    /// The file that the linker looks for.
    shared_object: &'static str,
    /// How the names of all files begin that it needs beside it.
    files: &'static [&'static str],
}

const EMBREE: Wanted = Wanted {
    name: "Embree 4",
    variable: "EMBREE_DIR",
    header: "embree4/rtcore_config.h",
    shared_object: "libembree4.so",
    // Embree finds its TBB by its own $ORIGIN, in the same folder.
    files: &["libembree4", "libtbb"],
};
const OCIO: Wanted = Wanted {
    name: "OpenColorIO 2",
    variable: "OCIO_DIR",
    header: "OpenColorIO/OpenColorABI.h",
    shared_object: "libOpenColorIO.so",
    files: &["libOpenColorIO"],
};

fn main() -> ExitCode {
    match build() {
        Ok(code) => code,
        Err(message) => {
            println!("cargo::error={message}");
            ExitCode::FAILURE
        }
    }
}

fn build() -> Result<ExitCode, String> {
    let root = PathBuf::from(variable("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(variable("OUT_DIR")?);
    let native = root.join(".native");

    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=.native/stamp");
    println!("cargo::rerun-if-env-changed=LIBCLANG_PATH");

    // bindgen takes libclang's folder from the environment alone, and to change one's own environment is unsafe: so this
    // script runs itself once more, with the variable set.
    if env::var_os("LIBCLANG_PATH").is_none() && native.join("libclang/libclang.so").is_file() {
        let this = env::current_exe()
            .map_err(|error| format!("the build script cannot find its own file: {error}"))?;
        let status = Command::new(this)
            .env("LIBCLANG_PATH", native.join("libclang"))
            .status()
            .map_err(|error| format!("the build script cannot start itself: {error}"))?;
        return Ok(if status.success() {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        });
    }

    write_double(&out)?;
    let embree = find(&EMBREE, &native)?;
    let ocio = find(&OCIO, &native)?;
    check_version(
        &EMBREE,
        &embree,
        "RTC_VERSION_STRING",
        EMBREE_AT_LEAST,
        "SUNDOG_EMBREE_HEADERS",
    )?;
    check_version(
        &OCIO,
        &ocio,
        "OCIO_VERSION",
        OCIO_AT_LEAST,
        "SUNDOG_OCIO_HEADERS",
    )?;

    bind_embree(&embree, &out)?;
    bind_ocio(&out)?;
    compile_shim(&ocio)?;
    link(&[(&EMBREE, &embree), (&OCIO, &ocio)], &out)?;
    Ok(ExitCode::SUCCESS)
}

/// Rooms of which the oracle has some files in f64, and these files. The rooms' own `mod.rs` come along.
const IN_DOUBLE: [(&str, &[&str]); 3] = [
    ("math", &["float", "frame", "warp"]),
    ("shading", &["fresnel", "ggx"]),
    (
        "light",
        &["lamp", "rectangle", "spherical_triangle", "triangle"],
    ),
];

/// Words and what takes their place. Those that are in f64 already come first, so that they stay.
const DOUBLED: [(&str, &str); 16] = [
    ("DVec2", "\u{1}2"),
    ("DVec3", "\u{1}3"),
    ("DMat3", "\u{2}3"),
    ("Vec2", "\u{1}2"),
    ("Vec3", "\u{1}3"),
    ("Mat3", "\u{2}3"),
    ("\u{1}", "DVec"),
    ("\u{2}", "DMat"),
    ("f32", "f64"),
    (".as_vec2()", ""),
    (".as_vec3()", ""),
    (".as_dvec2()", ""),
    (".as_dvec3()", ""),
    ("crate::", "crate::hard_cases::oracle::double::"),
    ("{DVec2, DVec2}", "DVec2"),
    ("{DAffine3, DVec3, DVec3}", "{DAffine3, DVec3}"),
];

/// Writes the source of the kernels in f64: the oracle against which they are measured in f32 (`tests/hard_cases/oracle.rs`). It is the
/// same text but for the types, so that it cannot fall behind.
fn write_double(out: &Path) -> Result<(), String> {
    let mut text = String::new();
    for (room, files) in IN_DOUBLE {
        let source = |name: &str| {
            let path = format!("src/{room}/{name}.rs");
            println!("cargo::rerun-if-changed={path}");
            let source = fs::read_to_string(&path)
                .map_err(|error| format!("{path} cannot be read: {error}"))?;
            // Tests come last; documentation has to stand before what it tells of, which may be gone.
            let code = source.split("#[cfg(test)]").next().unwrap_or_default();
            let lines = code
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"));
            Ok::<_, String>(lines.collect::<Vec<_>>().join("\n"))
        };
        let mut whole = String::new();
        for line in source("mod")?.lines() {
            let module = line
                .strip_prefix("pub mod ")
                .and_then(|rest| rest.strip_suffix(';'));
            match module {
                Some(name) if files.contains(&name) => {
                    whole += &format!("pub mod {name} {{\n{}\n}}\n", source(name)?);
                }
                Some(_) => {}
                // Names of files that did not come along.
                None if exports_another_file(line, files) => {}
                None => whole += &format!("{line}\n"),
            }
        }
        text += &format!("pub mod {room} {{\n{whole}\n}}\n");
    }
    for (word, instead) in DOUBLED {
        text = text.replace(word, instead);
    }
    let file = out.join("double.rs");
    fs::write(&file, text).map_err(|error| format!("{} cannot be written: {error}", file.display()))
}

/// Whether a line exports names of a file that is not among these.
fn exports_another_file(line: &str, files: &[&str]) -> bool {
    let path = line.strip_prefix("pub use ");
    let file = path.and_then(|path| path.split("::").next());
    file.is_some_and(|file| !files.contains(&file))
}

/// An environment variable that cargo always sets.
fn variable(name: &str) -> Result<OsString, String> {
    env::var_os(name).ok_or_else(|| format!("{name} is not set: build with cargo"))
}

fn find(wanted: &Wanted, native: &Path) -> Result<Library, String> {
    println!("cargo::rerun-if-env-changed={}", wanted.variable);
    if let Some(value) = env::var_os(wanted.variable).filter(|value| !value.is_empty()) {
        let found = if value == "system" {
            find_on_system(wanted)
        } else {
            find_in_prefix(wanted, Path::new(&value))
        };
        return found.ok_or_else(|| {
            format!(
                "{} was not found where {}={} points (looked for include/{} and {}); correct the variable, or unset it and run `make setup`",
                wanted.name,
                wanted.variable,
                value.to_string_lossy(),
                wanted.header,
                wanted.shared_object,
            )
        });
    }
    find_in_prefix(wanted, native).or_else(|| find_on_system(wanted)).ok_or_else(|| {
        format!(
            "{} is missing: `make setup` fetches it into .native/, or set {} to a prefix that has include/{} and lib/{}",
            wanted.name, wanted.variable, wanted.header, wanted.shared_object,
        )
    })
}

fn find_in_prefix(wanted: &Wanted, prefix: &Path) -> Option<Library> {
    // Rpaths have to be absolute, and the current folder of a later run is another.
    let prefix = prefix.canonicalize().ok()?;
    let include = prefix.join("include");
    if !include.join(wanted.header).is_file() {
        return None;
    }
    let lib = [
        "lib",
        "lib64",
        "lib/x86_64-linux-gnu",
        "lib/aarch64-linux-gnu",
    ]
    .iter()
    .map(|folder| prefix.join(folder))
    .find(|folder| folder.join(wanted.shared_object).exists())?;
    Some(Library {
        include,
        lib: Some(lib),
    })
}

fn find_on_system(wanted: &Wanted) -> Option<Library> {
    if let Some(found) = find_in_prefix(wanted, Path::new("/usr/local")) {
        return Some(found);
    }
    let found = find_in_prefix(wanted, Path::new("/usr"))?;
    // The loader knows /usr by itself: an rpath there would put it before the project's own libraries.
    Some(Library { lib: None, ..found })
}

/// Reads the version out of the header, refuses one that is too old, and hands it on to the crate.
fn check_version(
    wanted: &Wanted,
    library: &Library,
    define: &str,
    at_least: [u32; 3],
    rustc_env: &str,
) -> Result<(), String> {
    let header = library.include.join(wanted.header);
    let text = fs::read_to_string(&header)
        .map_err(|error| format!("{} cannot be read: {error}", header.display()))?;
    let version = text
        .lines()
        .filter_map(|line| {
            line.trim_start()
                .strip_prefix("#define")?
                .trim_start()
                .strip_prefix(define)
        })
        .find_map(|rest| {
            rest.strip_prefix([' ', '\t'])?
                .trim()
                .strip_prefix('"')?
                .strip_suffix('"')
        })
        .ok_or_else(|| {
            format!(
                "{} does not say its version ({define}): is it {}?",
                header.display(),
                wanted.name
            )
        })?;
    let mut numbers = [0_u32; 3];
    for (number, part) in numbers.iter_mut().zip(version.split('.')) {
        *number = part.parse().unwrap_or(0);
    }
    if numbers < at_least || numbers[0] != at_least[0] {
        let [major, minor, _] = at_least;
        return Err(format!(
            "{} has {} {version}, and Sundog needs {major}.{minor} or newer (below {}): `make setup` fetches one that fits, or set {}",
            library.include.display(),
            wanted.name,
            major + 1,
            wanted.variable,
        ));
    }
    println!("cargo::rustc-env={rustc_env}={version}");
    println!("cargo::rerun-if-changed={}", header.display());
    Ok(())
}

/// What both sets of bindings share. Enumerators keep their C names without the name of the enum before them.
fn bindings(header: &Path) -> bindgen::Builder {
    let mut builder = bindgen::builder()
        .header(header.to_string_lossy())
        .prepend_enum_name(false)
        .generate_comments(false)
        .formatter(bindgen::Formatter::None)
        .parse_callbacks(Box::new(bindgen::CargoCallbacks::new()));
    // libclang by itself has no stddef.h and the like; the C compiler's are looked at last.
    if let Some(folder) = compiler_headers() {
        builder = builder.clang_arg("-idirafter").clang_arg(folder);
    }
    builder
}

fn compiler_headers() -> Option<String> {
    let compiler = env::var_os("CC").unwrap_or_else(|| "cc".into());
    let output = Command::new(compiler)
        .arg("-print-file-name=include")
        .output()
        .ok()?;
    let folder = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    Path::new(&folder).is_dir().then_some(folder)
}

fn bind_embree(embree: &Library, out: &Path) -> Result<(), String> {
    let header = embree.include.join("embree4/rtcore.h");
    let made = generate(
        bindings(&header)
            .clang_arg(format!("-I{}", embree.include.display()))
            .allowlist_item("(rtc|RTC).*")
            // The inline helpers have no symbol in the library.
            .blocklist_function("rtcInit.*"),
        "Embree's headers",
    )?;
    write(&made, &out.join("embree.rs"))
}

fn bind_ocio(out: &Path) -> Result<(), String> {
    let header = Path::new("src/ffi/ocio_shim.h");
    let made = generate(
        bindings(header).allowlist_item("(sundog|Sundog|SUNDOG)_?.*"),
        "src/ffi/ocio_shim.h",
    )?;
    write(&made, &out.join("ocio.rs"))
}

fn generate(builder: bindgen::Builder, what: &str) -> Result<bindgen::Bindings, String> {
    // bindgen panics where it finds no libclang; the person gets a sentence instead.
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| builder.generate()))
        .map_err(|_| "libclang is missing: `make setup` fetches it into .native/, or set LIBCLANG_PATH to its folder".to_owned())?
        .map_err(|error| format!("bindgen cannot read {what}: {}", error.to_string().replace('\n', " ")))
}

fn write(bindings: &bindgen::Bindings, file: &Path) -> Result<(), String> {
    bindings
        .write_to_file(file)
        .map_err(|error| format!("{} cannot be written: {error}", file.display()))
}

fn compile_shim(ocio: &Library) -> Result<(), String> {
    println!("cargo::rerun-if-changed=src/ffi/ocio_shim.cpp");
    println!("cargo::rerun-if-changed=src/ffi/ocio_shim.h");
    let mut compiler = cc::Build::new();
    // (/usr/include must not be named: the compiler has it, and in another place it hides headers from libstdc++.)
    if ocio.include != Path::new("/usr/include") {
        compiler
            .flag("-isystem")
            .flag(ocio.include.to_string_lossy().as_ref());
    }
    compiler
        .cpp(true)
        .std("c++17")
        // The library exports std::string with the C++11 ABI, whatever the compiler's own default is.
        .define("_GLIBCXX_USE_CXX11_ABI", "1")
        .file("src/ffi/ocio_shim.cpp")
        .warnings(true)
        .extra_warnings(true)
        .try_compile("sundog_ocio_shim")
        .map_err(|error| format!("src/ffi/ocio_shim.cpp does not compile (is there a C++17 compiler? `make setup` installs one): {}", error.to_string().replace('\n', " ")))
}

/// Links both libraries so that they are found with no LD_LIBRARY_PATH: beside a program that was moved, in `.native/`
/// otherwise.
fn link(libraries: &[(&Wanted, &Library)], out: &Path) -> Result<(), String> {
    // cargo puts only search folders inside its target folder on the loader's path (documentation tests need that, since
    // they don't get the rpath): hence a folder of links there.
    let staged = out.join("lib");
    let failed = |error: std::io::Error| format!("{} cannot be made: {error}", staged.display());
    if staged.exists() {
        fs::remove_dir_all(&staged).map_err(failed)?;
    }
    fs::create_dir_all(&staged).map_err(failed)?;

    let mut rpaths = vec![
        "$ORIGIN".to_owned(),
        "$ORIGIN/lib".to_owned(),
        "$ORIGIN/../lib".to_owned(),
    ];
    for (wanted, library) in libraries {
        let name = wanted
            .shared_object
            .trim_start_matches("lib")
            .trim_end_matches(".so");
        println!("cargo::rustc-link-lib=dylib={name}");
        let Some(lib) = &library.lib else { continue };
        let entries = fs::read_dir(lib)
            .map_err(|error| format!("{} cannot be read: {error}", lib.display()))?;
        for entry in entries.flatten() {
            let file_name = entry.file_name();
            let text = file_name.to_string_lossy();
            // Only what belongs to this library: the other one may be asked for from another place.
            let belongs = wanted.files.iter().any(|start| text.starts_with(start));
            let link = staged.join(&file_name);
            if belongs && text.contains(".so") && !link.exists() {
                std::os::unix::fs::symlink(entry.path(), &link).map_err(failed)?;
            }
        }
        let rpath = lib.display().to_string();
        if !rpaths.contains(&rpath) {
            rpaths.push(rpath);
        }
    }
    println!("cargo::rustc-link-search=native={}", staged.display());

    // RPATH and not RUNPATH: OpenColorIO's soname has no version, so another one on LD_LIBRARY_PATH (a studio's, a
    // Blender's) would be taken for ours.
    println!("cargo::rustc-link-arg=-Wl,--disable-new-dtags");
    for rpath in rpaths {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{rpath}");
    }
    Ok(())
}
