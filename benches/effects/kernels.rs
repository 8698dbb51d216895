//! Kernels to compare: those of the program, and, made here alone, a scene's own with one effect more.

use sundog::effects::{self, Mask, PATHS, TABLE};
use sundog::integrator::{GENERAL, Kernel, kernel_for, trace};

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

/// The kernel for exactly a set, and for the set with each other effect.
macro_rules! with_each {
    ($set:expr) => {
        (
            $set,
            trace::<{ $set }> as Kernel,
            [
                trace::<{ $set | 1 }> as Kernel,
                trace::<{ $set | 1 << 1 }>,
                trace::<{ $set | 1 << 2 }>,
                trace::<{ $set | 1 << 3 }>,
                trace::<{ $set | 1 << 4 }>,
                trace::<{ $set | 1 << 5 }>,
                trace::<{ $set | 1 << 6 }>,
                trace::<{ $set | 1 << 7 }>,
                trace::<{ $set | 1 << 8 }>,
            ],
        )
    };
}

/// Sets whose exact kernels are made.
static EXACT: [(Mask, Kernel, [Kernel; 9]); 1] = [with_each!(effects::MESH_LIGHTS)];

/// The kernels to look at for a scene that calls for `needed`, the smallest first.
pub fn candidates(needed: Mask, added: bool) -> Vec<Candidate> {
    let needed = needed & PATHS;
    let (special, kernel) = kernel_for(needed);
    let mut list = vec![
        Candidate::new("special", special, kernel),
        Candidate::new("general", PATHS, GENERAL.1),
    ];
    if let Some((_, exact, more)) = EXACT.iter().find(|(set, ..)| added && *set == needed) {
        list.push(Candidate::new("exact", needed, *exact));
        for (bit, name, _) in TABLE {
            if bit & PATHS != 0 && bit & needed == 0 {
                let kernel = more[bit.trailing_zeros() as usize];
                list.push(Candidate::new(&format!("+ {name}"), needed | bit, kernel));
            }
        }
    }
    list
}
