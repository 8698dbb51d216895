//! The measures against independent implementations: PyPI's flip-evaluator, numpy and scikit-image.

mod convergence;
mod difference;
mod metadata;
mod peers;
mod pictures;

use std::path::{Path, PathBuf};
use std::process::Command;

/// The Python that has them: `SUNDOG_MEASURES_PYTHON`, else the one that the set-up keeps in the cache folder.
fn python() -> PathBuf {
    if let Some(python) = std::env::var_os("SUNDOG_MEASURES_PYTHON").filter(|path| !path.is_empty())
    {
        return python.into();
    }
    let cache = std::env::var_os("XDG_CACHE_HOME").map_or_else(
        || PathBuf::from(std::env::var_os("HOME").unwrap_or_default()).join(".cache"),
        PathBuf::from,
    );
    cache.join("sundog/measures/bin/python")
}

#[test]
fn measures_agree_with_independent_implementations() {
    let python = python();
    assert!(
        python.exists(),
        "{} is not there: run scripts/setup-measures.sh, or name a Python that has flip_evaluator, numpy, skimage, OpenEXR and PIL in SUNDOG_MEASURES_PYTHON",
        python.display()
    );
    let folder = tempfile::tempdir().unwrap();
    let done = Command::new(python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/measures.py"))
        .arg(env!("CARGO_BIN_EXE_sundog"))
        .arg(folder.path())
        // The same on every machine, with Blender or without.
        .env("OCIO", "ocio://default")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stdout);
    println!("{said}");
    assert!(
        done.status.success() && said.contains("agree"),
        "{said}{}",
        String::from_utf8_lossy(&done.stderr)
    );
}
