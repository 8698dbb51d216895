//! Kernels to compare: those of the program, and, made here alone, a scene's own with one effect more.

use sundog::effects::{
    COMPILED, ENVIRONMENT, GLOSS, INSTANCES, LAMPS, MESH_LIGHTS, METAL, Mask, PATHS, SMOOTH_NORMALS,
};
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
                trace::<{ $set | COMPILED[0].0 }> as Kernel,
                trace::<{ $set | COMPILED[1].0 }>,
                trace::<{ $set | COMPILED[2].0 }>,
                trace::<{ $set | COMPILED[3].0 }>,
                trace::<{ $set | COMPILED[4].0 }>,
                trace::<{ $set | COMPILED[5].0 }>,
                trace::<{ $set | COMPILED[6].0 }>,
                trace::<{ $set | COMPILED[7].0 }>,
                trace::<{ $set | COMPILED[8].0 }>,
                trace::<{ $set | COMPILED[9].0 }>,
                trace::<{ $set | COMPILED[10].0 }>,
                trace::<{ $set | COMPILED[11].0 }>,
                trace::<{ $set | COMPILED[12].0 }>,
            ],
        )
    };
}

/// Sets whose exact kernels are made: those of a Cornell box, of three objects under a sky, and of many lights (`scenes/build.py`).
static EXACT: [(Mask, Kernel, [Kernel; COMPILED.len()]); 3] = [
    with_each!(MESH_LIGHTS),
    with_each!(ENVIRONMENT | SMOOTH_NORMALS | METAL | GLOSS),
    with_each!(LAMPS | MESH_LIGHTS | SMOOTH_NORMALS | GLOSS | INSTANCES),
];

/// A set with all of each unit that it has some of.
fn whole(set: Mask) -> Mask {
    let units = COMPILED.iter().map(|(unit, _)| unit);
    units
        .filter(|unit| *unit & set != 0)
        .fold(0, |all, unit| all | unit)
}

/// The kernels to look at for a scene that calls for `needed`, the smallest first.
pub fn candidates(needed: Mask, added: bool) -> Vec<Candidate> {
    let needed = needed & PATHS;
    let (special, kernel) = kernel_for(needed);
    let mut list = vec![
        Candidate::new("special", special, kernel),
        Candidate::new("general", PATHS, GENERAL.1),
    ];
    if let Some((_, exact, more)) = EXACT
        .iter()
        .find(|(set, ..)| added && whole(*set) == whole(needed))
    {
        list.push(Candidate::new("exact", needed, *exact));
        for ((unit, name), kernel) in COMPILED.iter().zip(more) {
            if unit & needed == 0 {
                list.push(Candidate::new(&format!("+ {name}"), needed | unit, *kernel));
            }
        }
    }
    list
}
