//! How often Cycles' Light Tree draws each light. Clamping takes more from lights that are drawn more seldom, so that clamped pictures
//! depend on it: a sample that is drawn otherwise, with less noise, is clamped as if it were drawn so.
//!
//! Cycles follows Conty Estevez and Kulla, but takes one way through the tree: each turn goes by the mean of two shares, that of the most
//! that a cluster can give and that of the least. Lamps and meshes stand in one tree, the triangles of each mesh in another one below it,
//! and all lights at infinity in one leaf beside both.

mod bounds;
mod emitters;
mod side_by_side;

use super::lanes::LANES;
use super::set::Drawn;
use bounds::{Bounds, Cone, Measure, bounds_of};
use glam::Vec3;
use smallvec::SmallVec;

/// So many emitters stand in one leaf at most, but for lights at infinity.
const IN_A_LEAF: usize = 8;
/// Parts of a cluster between which it is cut.
const BUCKETS: usize = 12;
/// Branches with more emitters than this are built by several threads.
const WORTH_SHARING: usize = 1 << 12;

/// What is lit, as the tree sees it.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Where.
    pub point: Vec3,
    /// Its normal; `None` in a medium.
    pub normal: Option<Vec3>,
    /// Light from below its normal counts as well.
    pub both: bool,
}

/// A light as the tree sees it.
#[derive(Clone, Copy, Debug)]
pub struct Emitter {
    /// What kind it is.
    pub shape: Shape,
    /// Mean of the channels of the radiant intensity in the brightest direction; of lights at infinity the irradiance.
    pub energy: f32,
    /// Which light.
    pub drawn: Drawn,
}

/// What kind of light an emitter is.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// A point or a spot.
    Lamp {
        /// Its middle.
        center: Vec3,
        /// Its radius.
        radius: f32,
        /// A sphere, not a disc that faces what is lit.
        is_sphere: bool,
        /// A spot's axis, half its angle, and how steeply it falls off at its edge.
        cone: Option<(Vec3, f32, f32)>,
    },
    /// An area light.
    Area {
        /// Its middle.
        center: Vec3,
        /// The side to which it shines.
        normal: Vec3,
        /// Its edges.
        edges: [Vec3; 2],
        /// Half the angle of its spread.
        spread: f32,
    },
    /// A triangle that shines to both sides.
    Triangle([Vec3; 3]),
    /// Two of them that are a rectangle. In Cycles they are two lights, as likely together.
    Rectangle([Vec3; 4]),
    /// The direction to a sun, and half its angle.
    Sun(Vec3, f32),
    /// All around.
    World,
}

impl Emitter {
    /// Where the tree takes it to be.
    fn place(&self) -> Vec3 {
        match self.shape {
            Shape::Lamp { center, .. } | Shape::Area { center, .. } => center,
            Shape::Triangle([a, b, c]) => (a + b + c) / 3.0,
            Shape::Rectangle(corners) => corners.iter().sum::<Vec3>() / 4.0,
            Shape::Sun(..) | Shape::World => Vec3::ZERO,
        }
    }
}

/// What a leaf holds.
#[derive(Clone, Copy, Debug)]
enum Held {
    Light(Emitter),
    /// A mesh, by the first node of its tree.
    Mesh(u32),
}

/// A choice between two nodes.
#[derive(Clone, Copy, Debug)]
struct Turn {
    children: [u32; 2],
    /// The first of them is chosen.
    is_first: bool,
}

/// Something in its leaf.
#[derive(Clone, Copy, Debug)]
struct Entry {
    held: Held,
    cone: Cone,
    /// The leaf.
    node: u32,
}

#[derive(Clone, Copy, Debug)]
enum Below {
    Children([u32; 2]),
    /// Entries from the first one on, and how many.
    Entries(u32, u32),
}

#[derive(Clone, Copy, Debug)]
struct Node {
    measure: Measure,
    cone: Cone,
    below: Below,
    is_distant: bool,
    /// The node above; [`NONE`] at the first one of a tree.
    above: u32,
    /// The entry of the mesh whose tree begins here; [`NONE`] elsewhere.
    mesh: u32,
}

const NONE: u32 = u32::MAX;

/// The tree.
#[derive(Debug)]
pub struct TwoBounds {
    nodes: Vec<Node>,
    entries: Vec<Entry>,
    root: u32,
    /// By the numbers of lights the entries that they are; [`NONE`] for those that are none.
    finite: Vec<u32>,
    infinite: Vec<u32>,
}

/// What is put into a tree.
#[derive(Clone, Copy, Debug)]
struct Item {
    held: Held,
    measure: Measure,
    place: Vec3,
}

impl Item {
    fn light(emitter: &Emitter) -> Self {
        Self {
            held: Held::Light(*emitter),
            measure: Measure::of(emitter),
            place: emitter.place(),
        }
    }
}

/// What items are together.
fn all_of(items: &[Item]) -> Measure {
    let and = |measure: Measure, item: &Item| measure.and(&item.measure);
    items.iter().fold(Measure::NONE, and)
}

impl TwoBounds {
    /// Of lamps, of the triangles of each mesh, and of lights at infinity; lights have numbers below `counts`, finite ones first.
    pub fn new(
        lamps: &[Emitter],
        meshes: &[Vec<Emitter>],
        distant: &[Emitter],
        counts: (usize, usize),
    ) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            entries: Vec::new(),
            root: 0,
            finite: vec![NONE; counts.0],
            infinite: vec![NONE; counts.1],
        };
        let mut local: Vec<Item> = lamps.iter().map(Item::light).collect();
        for mesh in meshes {
            let mut items: Vec<Item> = mesh.iter().map(Item::light).collect();
            let root = tree.plant(&mut items);
            let measure = tree.nodes[root as usize].measure;
            local.push(Item {
                held: Held::Mesh(root),
                measure,
                place: 0.5 * (measure.min + measure.max),
            });
        }
        let near = tree.plant(&mut local);
        let far: Vec<Item> = distant.iter().map(Item::light).collect();
        let beyond = tree.nodes.len() as u32;
        tree.nodes.push(Node {
            is_distant: true,
            ..Node::leaf(all_of(&far), tree.entries.len(), far.len())
        });
        tree.hold(&far, beyond);
        tree.root = tree.nodes.len() as u32;
        for child in [near, beyond] {
            tree.nodes[child as usize].above = tree.root;
        }
        // Nothing asks for what the first node gives.
        tree.nodes.push(Node {
            below: Below::Children([near, beyond]),
            ..Node::leaf(Measure::NONE, 0, 0)
        });
        tree
    }

    /// Builds a tree over some items, and returns its first node.
    fn plant(&mut self, items: &mut [Item]) -> u32 {
        let mut nodes = Vec::with_capacity(items.len());
        build(items, self.entries.len(), &mut nodes);
        let first = self.nodes.len();
        let at = self.entries.len();
        append(&mut self.nodes, nodes);
        for node in first..self.nodes.len() {
            match self.nodes[node].below {
                Below::Children(children) => {
                    for child in children {
                        self.nodes[child as usize].above = node as u32;
                    }
                }
                Below::Entries(from, count) => {
                    let from = from as usize - at;
                    self.hold(&items[from..from + count as usize], node as u32);
                }
            }
        }
        first as u32
    }

    /// Puts items into a leaf; leaves come in the order of their items.
    fn hold(&mut self, items: &[Item], node: u32) {
        for item in items {
            let number = self.entries.len() as u32;
            let cone = match &item.held {
                Held::Mesh(root) => {
                    self.nodes[*root as usize].mesh = number;
                    item.measure.cone()
                }
                Held::Light(emitter) => {
                    match emitter.drawn {
                        Drawn::Finite(light) => self.finite[light as usize] = number,
                        Drawn::Infinite(light) => self.infinite[light as usize] = number,
                    }
                    Cone::of(emitter, &item.measure)
                }
            };
            self.entries.push(Entry {
                held: item.held,
                cone,
                node,
            });
        }
    }

    /// Probability with which Cycles draws a light.
    pub fn probability(&self, at: &Receiver, light: Drawn) -> f32 {
        let mut entry = match light {
            Drawn::Finite(number) => self.finite[number as usize],
            Drawn::Infinite(number) => self.infinite[number as usize],
        };
        let mut probability = 1.0f32;
        while entry != NONE {
            let leaf = self.entries[entry as usize].node;
            probability *= self.share(leaf, at, entry);
            let (turns, next) = self.turns(leaf);
            for turns in turns.chunks(LANES / 2) {
                if probability == 0.0 {
                    return 0.0;
                }
                let pairs = self.pairs(turns, at);
                for (turn, pair) in turns.iter().zip(pairs) {
                    let first = first_of(pair).unwrap_or(0.0);
                    probability *= if turn.is_first { first } else { 1.0 - first };
                }
            }
            match next {
                Some(mesh) => entry = mesh,
                None => return probability,
            }
        }
        0.0
    }

    /// The turns on the way up from a node, and the entry of the mesh whose tree that is: `None` in the first one.
    #[inline]
    fn turns(&self, mut child: u32) -> (SmallVec<[Turn; 32]>, Option<u32>) {
        let mut turns = SmallVec::new();
        loop {
            let Node { above, mesh, .. } = self.nodes[child as usize];
            if above == NONE {
                return (turns, Some(mesh));
            }
            if let Below::Children(children) = self.nodes[above as usize].below {
                turns.push(Turn {
                    children,
                    is_first: child == children[0],
                });
            }
            if above == self.root {
                return (turns, None);
            }
            child = above;
        }
    }

    /// What both children of each of up to four turns give.
    #[inline]
    fn pairs(&self, turns: &[Turn], at: &Receiver) -> [[Bounds; 2]; LANES / 2] {
        let one_by_one = |children: [u32; 2]| children.map(|child| self.bounds(child, at));
        if let [turn] = turns {
            let mut pairs = [[(0.0, 0.0); 2]; LANES / 2];
            pairs[0] = one_by_one(turn.children);
            return pairs;
        }
        let child = |lane: usize| {
            let turn = &turns[(lane / 2).min(turns.len() - 1)];
            &self.nodes[turn.children[lane % 2] as usize]
        };
        let nodes: [&Node; LANES] = std::array::from_fn(child);
        let mut found =
            side_by_side::of_clusters(nodes.map(|node| (&node.measure, &node.cone)), at);
        for (lane, node) in nodes.iter().enumerate().take(2 * turns.len()) {
            if node.is_single() {
                found[lane] = self.bounds_of_node(node, at);
            }
        }
        std::array::from_fn(|turn| [found[2 * turn], found[2 * turn + 1]])
    }

    /// What a node gives: one that holds a single light gives what that does.
    #[inline]
    fn bounds(&self, node: u32, at: &Receiver) -> Bounds {
        self.bounds_of_node(&self.nodes[node as usize], at)
    }

    fn bounds_of_node(&self, node: &Node, at: &Receiver) -> Bounds {
        match node.below {
            Below::Entries(_, 0) => (0.0, 0.0),
            Below::Entries(first, 1) => self.bounds_of(first, at),
            _ => node.measure.bounds(&node.cone, node.is_distant, at),
        }
    }

    /// What an entry gives.
    #[inline]
    fn bounds_of(&self, entry: u32, at: &Receiver) -> Bounds {
        let entry = &self.entries[entry as usize];
        match &entry.held {
            Held::Light(emitter) => bounds_of(emitter, &entry.cone, at),
            Held::Mesh(root) => {
                let node = &self.nodes[*root as usize];
                node.measure.bounds(&node.cone, false, at)
            }
        }
    }

    /// The share of one entry of a leaf; 1 of what is no leaf.
    fn share(&self, leaf: u32, at: &Receiver, of: u32) -> f32 {
        let leaf = &self.nodes[leaf as usize];
        let Below::Entries(first, count) = leaf.below else {
            return 1.0;
        };
        let (mut sums, mut own) = (Sums::default(), (0.0, 0.0));
        for entry in first..first + count {
            let bounds = self.bounds_of(entry, at);
            sums.add(bounds);
            if entry == of {
                own = bounds;
            }
        }
        sums.share(own)
    }
}

/// Probability of the first of two children; `None` where none of them gives anything.
#[inline]
fn first_of([a, b]: [Bounds; 2]) -> Option<f32> {
    let most = a.0 + b.0;
    if most <= 0.0 {
        return None;
    }
    let least = a.1 + b.1;
    let by_least = if least > 0.0 {
        a.1 / least
    } else {
        0.5 * (f32::from(a.0 > 0.0) + f32::from(b.0 == 0.0))
    };
    Some(0.5 * (a.0 / most + by_least))
}

/// What the entries of a leaf give together.
#[derive(Clone, Copy, Default)]
struct Sums {
    most: f32,
    least: f32,
    shining: f32,
}

impl Sums {
    #[inline]
    fn add(&mut self, (most, least): Bounds) {
        self.most += most;
        self.least += least;
        self.shining += f32::from(most > 0.0);
    }

    /// The mean of the two shares of one; where none gives anything at least, all that may shine have the same second one.
    #[inline]
    fn share(&self, (most, least): Bounds) -> f32 {
        if most <= 0.0 {
            return 0.0;
        }
        let by_least = if self.least > 0.0 {
            least / self.least
        } else {
            1.0 / self.shining
        };
        0.5 * (most / self.most + by_least)
    }
}

impl Node {
    fn leaf(measure: Measure, first: usize, count: usize) -> Self {
        Self {
            cone: measure.cone(),
            measure,
            below: Below::Entries(first as u32, count as u32),
            is_distant: false,
            above: NONE,
            mesh: NONE,
        }
    }

    /// Whether it gives something else than a cluster would.
    #[inline]
    fn is_single(&self) -> bool {
        self.is_distant || matches!(self.below, Below::Entries(_, 0 | 1))
    }
}

/// Appends nodes whose own numbers begin at 0.
fn append(nodes: &mut Vec<Node>, more: Vec<Node>) {
    let at = nodes.len() as u32;
    nodes.extend(more.into_iter().map(|node| Node {
        below: match node.below {
            Below::Children(children) => Below::Children(children.map(|child| child + at)),
            entries => entries,
        },
        ..node
    }));
}

/// Appends a tree over items, of which the first is the entry of a number; they are put into the order of their leaves.
fn build(items: &mut [Item], first: usize, nodes: &mut Vec<Node>) {
    let at = nodes.len();
    let (measure, cut) = split(items);
    nodes.push(Node::leaf(measure, first, items.len()));
    let Some(middle) = cut else {
        return;
    };
    let (left, right) = items.split_at_mut(middle);
    let second;
    if left.len().min(right.len()) > WORTH_SHARING {
        // The same nodes in the same places, made by several threads.
        let [mut before, mut behind] = [Vec::new(), Vec::new()];
        rayon::join(
            || build(left, first, &mut before),
            || build(right, first + middle, &mut behind),
        );
        append(nodes, before);
        second = nodes.len();
        append(nodes, behind);
    } else {
        build(left, first, nodes);
        second = nodes.len();
        build(right, first + middle, nodes);
    }
    nodes[at].below = Below::Children([at + 1, second].map(|child| child as u32));
}

/// What items are together, and where they are cut if they are: put in order about that place.
fn split(items: &mut [Item]) -> (Measure, Option<usize>) {
    if items.len() < 2 {
        return (all_of(items), None);
    }
    let low = items.iter().fold(Vec3::INFINITY, |v, i| v.min(i.place));
    let high = items.iter().fold(Vec3::NEG_INFINITY, |v, i| v.max(i.place));
    let extent = high - low;
    let (mut measure, mut total) = (None, 0.0);
    let mut best: Option<(f32, usize, usize)> = None;
    // In the order of Blender's axes.
    for axis in [0, 2, 1] {
        if extent[axis] <= 0.0 {
            continue;
        }
        let scale = BUCKETS as f32 / extent[axis];
        let mut buckets = [(Measure::NONE, 0usize); BUCKETS];
        for item in items.iter() {
            let bucket = ((item.place[axis] - low[axis]) * scale) as usize;
            let (of, count) = &mut buckets[bucket.min(BUCKETS - 1)];
            *of = of.and(&item.measure);
            *count += 1;
        }
        let mut before = buckets;
        for bucket in 1..BUCKETS {
            let sum = before[bucket - 1];
            before[bucket] = (sum.0.and(&buckets[bucket].0), sum.1 + buckets[bucket].1);
        }
        let mut behind = buckets;
        for bucket in (1..BUCKETS - 1).rev() {
            behind[bucket].0 = buckets[bucket].0.and(&behind[bucket + 1].0);
        }
        if measure.is_none() {
            let whole = before[BUCKETS - 1].0;
            total = whole.cost();
            measure = Some(whole);
            if total == 0.0 {
                break;
            }
        }
        let narrow = extent.max_element() / extent[axis];
        for cut in 1..BUCKETS {
            let cost = narrow * (before[cut - 1].0.cost() + behind[cut].0.cost());
            if cost < total && best.is_none_or(|best| cost < best.0) {
                best = Some((cost, axis, before[cut - 1].1));
            }
        }
    }
    let measure = measure.unwrap_or_else(|| all_of(items));
    match best {
        Some((_, axis, middle)) if middle > 0 && middle < items.len() => {
            let along = |item: &Item| item.place[axis];
            items.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
            (measure, Some(middle))
        }
        _ if items.len() > IN_A_LEAF => (measure, Some(items.len() / 2)),
        _ => (measure, None),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/two_bounds.rs"]
mod tests;
