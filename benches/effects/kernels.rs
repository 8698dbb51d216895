//! Kernels to compare: the one that a scene's effects choose, and the general one.

use sundog::effects::{Mask, PATHS};
use sundog::integrator::{GENERAL, Kernel, kernel_for};

/// A kernel to look at.
pub struct Candidate {
    pub name: String,
    pub mask: Mask,
    pub kernel: Kernel,
}

impl Candidate {
    fn new(name: &str, mask: Mask, kernel: Kernel) -> Self {
        Self {
            name: name.into(),
            mask,
            kernel,
        }
    }
}

/// The kernels to look at for a scene that calls for `needed`, the smallest first.
pub fn candidates(needed: Mask) -> Vec<Candidate> {
    let needed = needed & PATHS;
    let (special, kernel) = kernel_for(needed);
    let list = vec![
        Candidate::new("special", special, kernel),
        Candidate::new("general", PATHS, GENERAL.1),
    ];
    list
}
