//! Networks of shaders, followed from where they end.

use std::collections::HashMap;

use openusd::sdf::{Path, Value};

use super::materials::Needs;
use super::source::{Source, View};
use super::textures::Images;
use super::{materialx, preview, value};
use crate::nodes::math::Math;
use crate::nodes::vector_math::VectorMath;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::{Function, Graph, Input, Link, Node, NodeKind};
use crate::scene::{Diagnostics, Subject, Verdict};

/// Connections and nodes behind each other: more are a circle.
const DEEPEST: usize = 256;

/// What a node or an input gives: up to four numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Term {
    /// The first three, or one three times.
    pub rgb: Input,
    /// The fourth.
    pub a: Input,
    /// How many there are.
    pub size: u8,
}

impl Term {
    pub(super) fn number(value: f32) -> Self {
        Self {
            rgb: Input::float(value),
            a: Input::float(1.0),
            size: 1,
        }
    }

    pub(super) fn color(value: [f32; 3]) -> Self {
        Self {
            rgb: Input::Value(value),
            a: Input::float(1.0),
            size: 3,
        }
    }

    pub(super) fn link(link: Link, size: u8) -> Self {
        Self {
            rgb: Input::Link(link),
            a: Input::float(1.0),
            size,
        }
    }

    /// The numbers, if they are the same everywhere.
    pub(super) fn constant(self) -> Option<[f32; 3]> {
        match self.rgb {
            Input::Value(value) => Some(value),
            _ => None,
        }
    }

    pub(super) fn is(self, number: f32) -> bool {
        self.constant() == Some([number; 3])
    }

    /// A value of an attribute.
    pub(super) fn of(value: &Value) -> Option<Self> {
        let (size, numbers) = value::floats(value)?;
        let at = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
        Some(match size {
            1 => Self::number(at(0)),
            _ => Self {
                rgb: Input::Value([at(0), at(1), at(2)]),
                a: Input::float(if size == 4 { at(3) } else { 1.0 }),
                size: size as u8,
            },
        })
    }
}

/// What an input is connected to.
pub(super) enum Found {
    Nothing,
    Value(Value),
    /// A shader's output.
    Node(Path, String),
}

/// The network of one material, becoming a graph.
pub(super) struct Network<'m> {
    pub source: Option<&'m Source>,
    pub images: Option<&'m mut Images>,
    pub diagnostics: Option<&'m mut Diagnostics>,
    pub graph: Graph,
    pub needs: Needs,
    pub material: String,
    /// All of its nodes are known.
    pub complete: bool,
    known: HashMap<(String, String), Option<Term>>,
    open: usize,
}

impl<'m> Network<'m> {
    pub(super) fn new(
        source: &'m Source,
        images: &'m mut Images,
        diagnostics: &'m mut Diagnostics,
        name: &str,
    ) -> Self {
        Self {
            source: Some(source),
            images: Some(images),
            diagnostics: Some(diagnostics),
            material: name.into(),
            ..Self::bare()
        }
    }

    /// One without a file.
    pub(super) fn bare() -> Self {
        Self {
            source: None,
            images: None,
            diagnostics: None,
            graph: Graph::default(),
            needs: Needs::default(),
            material: String::new(),
            complete: true,
            known: HashMap::new(),
            open: 0,
        }
    }

    pub(super) fn report(
        &mut self,
        code: &'static str,
        verdict: Verdict,
        feature: String,
        instead: &str,
    ) {
        let material = Subject::Material(self.material.clone());
        if let Some(diagnostics) = &mut self.diagnostics {
            diagnostics.report(code, verdict, feature, material, instead);
        }
    }

    /// The shader at the end of an output of a material.
    pub(super) fn shader(&mut self, prim: &View, output: &str) -> Option<(Path, String)> {
        match self.follow(&prim.property(output)?) {
            Found::Node(path, output) => Some((path, output)),
            _ => None,
        }
    }

    /// Goes along connections, through interfaces of node graphs and of the material.
    fn follow(&mut self, attribute: &Path) -> Found {
        let Some(source) = self.source else {
            return Found::Nothing;
        };
        let mut at = attribute.clone();
        for _ in 0..DEEPEST {
            let connections = source.stage.attribute(at.clone()).connections();
            let connections = source.told(&at, connections).unwrap_or_default();
            let Some(target) = connections.into_iter().next() else {
                return match source.value(&at) {
                    Some(value) => Found::Value(value),
                    None => Found::Nothing,
                };
            };
            let Some((prim, property)) = target.split_property() else {
                return Found::Nothing;
            };
            if let Some(output) = property.strip_prefix("outputs:") {
                let name = source.stage.prim(prim.clone()).type_name();
                let name = source.told(&prim, name).flatten();
                if name.is_some_and(|name| name.as_str() == "Shader") {
                    let output = output.to_owned();
                    return Found::Node(prim, output);
                }
            }
            at = target.clone();
        }
        Found::Nothing
    }

    /// What stands in an input of a shader.
    pub(super) fn find(&mut self, shader: &View, input: &str) -> Found {
        let name = format!("inputs:{input}");
        match shader.property(&name).filter(|_| shader.has(&name)) {
            Some(path) => self.follow(&path),
            None => Found::Nothing,
        }
    }

    /// What an input gives, if something does.
    pub(super) fn input(&mut self, shader: &View, input: &str) -> Option<Term> {
        match self.find(shader, input) {
            Found::Nothing => None,
            Found::Value(value) => Term::of(&value),
            Found::Node(path, output) => self.node(&path, &output),
        }
    }

    pub(super) fn input_or(&mut self, shader: &View, input: &str, fallback: Term) -> Term {
        self.input(shader, input).unwrap_or(fallback)
    }

    /// A word in an input.
    pub(super) fn word(&mut self, shader: &View, input: &str) -> Option<String> {
        match self.find(shader, input) {
            Found::Value(value) => value::word(&value),
            _ => None,
        }
    }

    /// A number in an input that has to be the same everywhere.
    pub(super) fn plain(&mut self, shader: &View, input: &str) -> Option<f32> {
        match self.find(shader, input) {
            Found::Value(value) => value::number(&value).map(|v| v as f32),
            _ => None,
        }
    }

    /// The file that an input names: where it is, and how it is called.
    pub(super) fn asset(&mut self, shader: &View, input: &str) -> Option<(String, String)> {
        let source = self.source?;
        match self.find(shader, input) {
            Found::Value(value) => {
                let at = shader.property(&format!("inputs:{input}"))?;
                source.place(&value::asset(&value)?, &at)
            }
            _ => None,
        }
    }

    /// What a node gives.
    pub(super) fn node(&mut self, path: &Path, output: &str) -> Option<Term> {
        let key = (path.to_string(), output.to_owned());
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        if self.open > DEEPEST {
            self.report(
                "usd-cycle",
                Verdict::Lost,
                "shaders that are connected in a circle".into(),
                "the input at which it closes has its own value",
            );
            return None;
        }
        self.open += 1;
        // Until it is known it gives nothing, to itself too.
        self.known.insert(key.clone(), None);
        let shader = self.source?.view(path);
        let id = shader.word("info:id").unwrap_or_default();
        let term = if id.starts_with("Usd") {
            preview::node(self, &shader, &id, output)
        } else {
            materialx::node(self, &shader, &id, output)
        };
        self.open -= 1;
        if term.is_none() {
            self.unknown(&id);
        }
        self.known.insert(key, term);
        term
    }

    fn unknown(&mut self, id: &str) {
        self.complete = false;
        self.report(
            "usd-node",
            Verdict::Lost,
            format!("shader node {id}"),
            "what it feeds has its own value",
        );
    }

    /// The number of a set of texture coordinates.
    pub(super) fn uv_set(&mut self, name: &str) -> u32 {
        place(&mut self.needs.uvs, name) as u32
    }

    /// The number of another primvar.
    pub(super) fn attribute(&mut self, name: &str, fallback: [f32; 4]) -> u32 {
        let at = place(&mut self.needs.attributes, name);
        if self.needs.fallbacks.len() <= at {
            self.needs.fallbacks.push(fallback);
        }
        at as u32
    }

    pub(super) fn function(&mut self, function: Function, inputs: &[Input]) -> Link {
        let mut node = Node::new(NodeKind::Function(function));
        for (to, from) in node.inputs.iter_mut().zip(inputs) {
            *to = *from;
        }
        self.graph.add(node)
    }

    pub(super) fn place(&mut self, input: PlaceInput) -> Link {
        self.function(Function::Place(input), &[])
    }

    /// Arithmetic of numbers.
    pub(super) fn math(&mut self, operation: Math, inputs: &[Input]) -> Input {
        let constant = |input: &Input| match input {
            Input::Value([v, ..]) => Some(*v),
            _ => None,
        };
        let values: Option<Vec<f32>> = inputs.iter().map(constant).collect();
        if let Some(values) = values {
            let at = |i: usize| values.get(i).copied().unwrap_or(0.5);
            return Input::float(operation.of(at(0), at(1), at(2)));
        }
        let clamp = false;
        self.function(Function::Math { operation, clamp }, inputs)
            .into()
    }

    /// Arithmetic of vectors.
    pub(super) fn vector(&mut self, operation: VectorMath, inputs: &[Input]) -> Input {
        let constant = |input: &Input| match input {
            Input::Value(v) => Some(glam::Vec3::from(*v)),
            _ => None,
        };
        let values: Option<Vec<glam::Vec3>> = inputs.iter().map(constant).collect();
        if let Some(values) = values {
            let at = |i: usize| values.get(i).copied().unwrap_or_default();
            let (vector, number) = operation.of(at(0), at(1), at(2), 1.0);
            return match operation {
                VectorMath::DotProduct | VectorMath::Length | VectorMath::Distance => {
                    Input::float(number)
                }
                _ => Input::Value(vector.to_array()),
            };
        }
        let link = self.function(Function::VectorMath(operation), inputs);
        let output = u8::from(matches!(
            operation,
            VectorMath::DotProduct | VectorMath::Length | VectorMath::Distance
        ));
        Link { output, ..link }.into()
    }

    /// One of the numbers of a term.
    pub(super) fn channel(&mut self, term: Term, at: u8) -> Input {
        match (at, term.rgb) {
            (3, _) => term.a,
            (_, Input::Value(v)) => Input::float(v[usize::from(at)]),
            (_, Input::Link(_)) if term.size > 1 => {
                let link = self.function(Function::SeparateXyz, &[term.rgb]);
                Link { output: at, ..link }.into()
            }
            (_, other) => other,
        }
    }

    /// A term times some numbers, and others added.
    pub(super) fn scaled(&mut self, term: Term, by: [f32; 4], plus: [f32; 4]) -> Term {
        let [r, g, b, a] = by;
        let [x, y, z, w] = plus;
        let mut scaled = term;
        if [r, g, b, x, y, z] != [1.0, 1.0, 1.0, 0.0, 0.0, 0.0] {
            let inputs = [term.rgb, Input::Value([r, g, b]), Input::Value([x, y, z])];
            scaled.rgb = self.vector(VectorMath::MultiplyAdd, &inputs);
        }
        if [a, w] != [1.0, 0.0] {
            let inputs = [term.a, Input::float(a), Input::float(w)];
            scaled.a = self.math(Math::MultiplyAdd, &inputs);
        }
        scaled
    }
}

fn place(names: &mut Vec<String>, name: &str) -> usize {
    if let Some(at) = names.iter().position(|n| n == name) {
        return at;
    }
    names.push(name.into());
    names.len() - 1
}
