//! What graphs tell passes of the scene's own (Blender's AOVs).

use super::compile::{Compiler, Source, root};
use super::{Place, Program, Root};
use crate::scene::graph::{AovOutput, Graph, Input};

/// What is told to passes of the scene's own.
#[derive(Clone, Debug)]
pub struct Aovs {
    /// Operations of all of it.
    pub program: Program,
    /// First float, whether it is a colour, and where the value is.
    roots: Vec<(usize, bool, Root)>,
}

impl Aovs {
    /// Adds the values at a place to the sums of a pixel. Colours have an alpha of 1.
    pub fn add(&self, place: &impl Place, sums: &mut [f64]) {
        self.program.at(place, |at| {
            for (first, is_color, root) in &self.roots {
                let Some(sums) = sums.get_mut(*first..) else {
                    continue;
                };
                if *is_color {
                    let value = at.color(root).extend(1.0).to_array();
                    let sums = sums.iter_mut().zip(value);
                    sums.for_each(|(sum, value)| *sum += f64::from(value));
                } else if let Some(sum) = sums.first_mut() {
                    *sum += f64::from(at.number(root));
                }
            }
        });
    }
}

/// What passes of the scene's own are told.
pub(super) fn aovs(graph: &Graph, source: &mut impl Source) -> Option<Box<Aovs>> {
    if graph.aovs.is_empty() {
        return None;
    }
    let mut heights = 0;
    let mut compiler = Compiler::new(graph, source, &mut heights);
    let of = |aov: &AovOutput| {
        let operand = compiler.operand(aov.value.map_or(Input::None, Input::Link));
        (aov.first as usize, aov.is_color, root(operand))
    };
    let mut roots: Vec<_> = graph.aovs.iter().map(of).collect();
    let mut all: Vec<&mut Root> = roots.iter_mut().map(|(.., root)| root).collect();
    let program = compiler.finish(&mut all);
    Some(Box::new(Aovs { program, roots }))
}
