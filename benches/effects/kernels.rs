//! Kernels to compare: the one that a scene's effects choose, and the general one.

use enumset::EnumSet;
use sundog::effects::{Effect, PATHS};
use sundog::integrator::{GENERAL, Kernel, kernel_for};

/// A kernel to look at.
pub struct Candidate {
    pub name: String,
    pub effects: EnumSet<Effect>,
    pub kernel: Kernel,
}

impl Candidate {
    fn new(name: &str, effects: EnumSet<Effect>, kernel: Kernel) -> Self {
        Self {
            name: name.into(),
            effects,
            kernel,
        }
    }
}

/// The kernels to look at for a scene that calls for `needed`, the smallest first.
pub fn candidates(needed: EnumSet<Effect>) -> Vec<Candidate> {
    let needed = needed & PATHS;
    let (special, kernels) = kernel_for(needed);
    let list = vec![
        Candidate::new("special", special, kernels.plain),
        Candidate::new("general", PATHS, GENERAL.1.plain),
    ];
    list
}
