//! The parts of a glTF file that are read in f64 or that the `gltf` crate has no schema for.

use super::camera_schema::CameraJson;
use super::ies_lights::IesJson;
use super::medium::MediumJson;
use super::strands::StrandsJson;
use super::words;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::scene::{Links, ObjectInfo, RayKind, TextureSpace, Visibility};

/// Scenes, nodes, cameras, skins and lights.
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub scene: Option<usize>,
    pub scenes: Vec<SceneJson>,
    pub cameras: Vec<CameraJson>,
    pub skins: Vec<SkinJson>,
    pub lights: Vec<LightJson>,
    pub extensions_required: Vec<String>,
}

#[derive(Debug, Deserialize)]
pub(super) struct SceneJson {
    pub name: Option<String>,
    #[serde(default)]
    pub nodes: Vec<usize>,
    #[serde(default)]
    pub extensions: SceneExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct SceneExtensions {
    #[serde(rename = "SUNDOG_scene")]
    pub sundog: Option<SundogScene>,
}

/// What glTF has no word for in a scene. See `docs/gltf-extensions.md`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct SundogScene {
    pub working_space: Option<String>,
    pub world: Option<WorldJson>,
    pub color_management: Option<ColorManagementJson>,
    pub render: Option<RenderJson>,
    pub shutter: Option<ShutterJson>,
    pub fast_gi: Option<FastGiJson>,
    pub texture_limit: Option<TextureLimitJson>,
    #[serde(default)]
    pub light_groups: Vec<String>,
    #[serde(default)]
    pub aovs: Vec<AovJson>,
    /// What is not known.
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// What stands for indirect light.
#[derive(Debug, Deserialize)]
pub(super) struct FastGiJson {
    /// "replace" or "add".
    pub method: String,
    /// Of "replace".
    #[serde(default)]
    pub bounces: u32,
    pub factor: f32,
    pub distance: f32,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// How large images may be.
#[derive(Debug, Deserialize)]
pub(super) struct TextureLimitJson {
    /// Share of their pixels along each side.
    #[serde(default = "whole")]
    pub resolution: f32,
    /// Most pixels along a side.
    pub size: Option<u32>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

fn whole() -> f32 {
    1.0
}

/// A pass of the scene's own.
#[derive(Debug, Deserialize)]
pub(super) struct AovJson {
    pub name: String,
    /// "COLOR" or "VALUE".
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// How the shutter lets light through.
#[derive(Debug, Default, Deserialize)]
pub(super) struct ShutterJson {
    #[serde(default)]
    pub curve: Vec<f32>,
    pub rolling: Option<f32>,
    #[serde(default)]
    pub still: bool,
    #[serde(default)]
    pub objects_alone: bool,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// What glTF has no word for in a material. See `docs/gltf-extensions.md`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct SundogMaterial {
    pub base_color: Option<[f32; 3]>,
    pub specular: Option<f32>,
    pub thin_walled: Option<bool>,
    pub diffuse_roughness: Option<f32>,
    pub glossy: Option<GlossyJson>,
    pub transparent_color: Option<[f32; 3]>,
    pub edge_tint: Option<bool>,
    pub anisotropy: Option<AnisotropyJson>,
    pub bsdf: Option<BsdfJson>,
    pub coat: Option<CoatJson>,
    pub sheen: Option<SheenJson>,
    pub thin_film: Option<ThinFilmJson>,
    pub pass_index: Option<f32>,
    pub aovs: Option<Value>,
    pub volume: Option<MediumJson>,
    pub priority: Option<i32>,
    /// What is not rendered, and what is not known.
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// A thin film: nanometres, and its index.
#[derive(Debug, Deserialize)]
pub(super) struct ThinFilmJson {
    pub thickness: f32,
    #[serde(default = "film_ior")]
    pub ior: f32,
}

fn film_ior() -> f32 {
    1.33
}

/// Anisotropy by Blender's numbers.
#[derive(Debug, Deserialize)]
pub(super) struct AnisotropyJson {
    pub strength: f32,
    #[serde(default)]
    pub rotation: f32,
    #[serde(default)]
    pub tangent: TangentJson,
    #[serde(default)]
    pub uv_set: u32,
}

/// A shader of one lobe.
#[derive(Debug, Deserialize)]
pub(super) struct BsdfJson {
    #[serde(rename = "type")]
    pub kind: BsdfKindJson,
    /// Further scatterings are there.
    #[serde(default)]
    pub multiscatter: bool,
    /// Numbers and colours by the names of Blender's sockets.
    #[serde(default)]
    pub inputs: Map<String, Value>,
}

/// Which shader.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum BsdfKindJson {
    Translucent,
    Refraction,
    Glass,
    Metallic,
    Conductor,
    Sheen,
    DiffuseToon,
    GlossyToon,
}

/// Blender's coat.
#[derive(Debug, Deserialize)]
pub(super) struct CoatJson {
    #[serde(default)]
    pub weight: f32,
    #[serde(default)]
    pub roughness: f32,
    pub ior: Option<f32>,
    #[serde(default = "white")]
    pub tint: [f32; 3],
}

/// Blender's sheen.
#[derive(Debug, Deserialize)]
pub(super) struct SheenJson {
    #[serde(default)]
    pub weight: f32,
    #[serde(default)]
    pub roughness: f32,
    #[serde(default = "white")]
    pub tint: [f32; 3],
}

/// What a tangent follows.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum TangentJson {
    #[default]
    Radial,
    Uv,
}

/// What glTF has no word for in a primitive. See `docs/gltf-extensions.md`.
#[derive(Debug, Deserialize)]
pub(super) struct SundogMesh {
    pub texture_space: Option<TextureSpaceJson>,
    pub generated: Option<String>,
    pub vertices: Option<String>,
    pub vertex_normals: Option<String>,
    #[serde(default)]
    pub motion: Vec<MeshStepJson>,
    #[serde(default)]
    pub grids: Vec<GridJson>,
    #[serde(default)]
    pub density_by_object: bool,
    /// Sets of texture coordinates that stand for maps that it does not have.
    #[serde(default)]
    pub absent_uvs: Vec<u32>,
    pub strands: Option<StrandsJson>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// A grid of what fills a mesh: one of an OpenVDB file, or an array.
#[derive(Debug, Deserialize)]
pub(super) struct GridJson {
    /// The number that node trees have for it.
    pub number: usize,
    pub name: String,
    /// The file.
    pub uri: Option<String>,
    /// Of the array.
    pub accessor: Option<usize>,
    #[serde(default)]
    pub size: [i32; 3],
    /// From the array's points to the object's space, by rows.
    pub matrix: Option<[f64; 12]>,
}

/// The attributes that hold a mesh's vertices at a step of time.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct MeshStepJson {
    pub position: String,
    pub normal: Option<String>,
}

/// The box that generated coordinates are 0 to 1 in: its middle, and from there to its sides.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct TextureSpaceJson {
    pub location: [f32; 3],
    pub size: [f32; 3],
}

impl From<TextureSpaceJson> for TextureSpace {
    fn from(TextureSpaceJson { location, size }: TextureSpaceJson) -> Self {
        Self { location, size }
    }
}

/// The facets of a Glossy BSDF.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum GlossyJson {
    Ggx,
    MultiscatterGgx,
}

#[derive(Debug, Deserialize)]
pub(super) struct ColorManagementJson {
    pub display: Option<String>,
    pub view: Option<String>,
    pub look: Option<String>,
    pub exposure: Option<f64>,
    pub gamma: Option<f64>,
    pub config: Option<String>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

#[derive(Debug, Deserialize)]
pub(super) struct RenderJson {
    pub width: Option<u32>,
    pub height: Option<u32>,
    pub filter_width: Option<f64>,
    pub transparent: Option<bool>,
    pub transparent_glass: Option<f64>,
    pub film_exposure: Option<f64>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// The light from all around. See `docs/gltf-extensions.md`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct WorldJson {
    pub color: Option<[f32; 3]>,
    pub image: Option<String>,
    pub rotation: Option<[f64; 9]>,
    pub sun: Option<WorldSunJson>,
    pub shader_graph: Option<Value>,
    pub aovs: Option<Value>,
    pub sampling: Option<SamplingJson>,
    pub volume: Option<MediumJson>,
    #[serde(default)]
    pub visibility: RaysJson,
    pub light_group: Option<String>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// How light sampling finds the world.
#[derive(Debug, Default, Deserialize)]
pub(super) struct SamplingJson {
    /// Columns of its table; 0 leaves it to the program.
    #[serde(default)]
    pub resolution: u32,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// The disc of the sun in the world.
#[derive(Debug, Deserialize)]
pub(super) struct WorldSunJson {
    /// Toward it, by Blender's axes.
    pub direction: [f64; 3],
    /// Angular diameter, radians.
    pub angle: f32,
    /// Irradiance on a surface that faces it, W/m².
    pub strength: [f32; 3],
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// Ray visibility; what is left out sees.
#[derive(Debug, Default, Deserialize)]
pub(super) struct RaysJson(Map<String, Value>);

impl RaysJson {
    /// As the scene has it; names that mean nothing, or values that are no booleans, go to `unknown`.
    pub(super) fn visibility(&self, mut unknown: impl FnMut(&str)) -> Visibility {
        let mut seen = Visibility::ALL;
        for (name, value) in &self.0 {
            let kind = RayKind::ALL.iter().find(|(_, known)| known == name);
            match (kind, value) {
                (Some(_), Value::Bool(true)) => {}
                (Some((kind, _)), Value::Bool(false)) => seen = seen.without(*kind),
                _ => unknown(name),
            }
        }
        seen
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct NodeJson {
    pub name: Option<String>,
    #[serde(default)]
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub camera: Option<usize>,
    pub weights: Option<Vec<f64>>,
    #[serde(default)]
    pub extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<LightReference>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<InstancingJson>,
    #[serde(rename = "EXT_lights_ies")]
    pub ies: Option<IesJson>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<VisibilityJson>,
    #[serde(rename = "SUNDOG_light")]
    pub area: Option<SundogLight>,
    #[serde(rename = "SUNDOG_object")]
    pub object: Option<SundogObject>,
}

/// What a node with a mesh says beyond glTF. See `docs/gltf-extensions.md`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct SundogObject {
    #[serde(default)]
    pub visibility: RaysJson,
    #[serde(default)]
    pub holdout: bool,
    pub color: Option<[f32; 4]>,
    pub pass_index: Option<f32>,
    pub random: Option<f32>,
    pub shading_offset: Option<f32>,
    #[serde(default)]
    pub fast_gi_distance: f32,
    #[serde(default)]
    pub own_mesh: bool,
    pub asset: Option<String>,
    #[serde(flatten)]
    pub links: LinksJson,
    #[serde(default)]
    pub values: Vec<[f32; 4]>,
    #[serde(default)]
    pub motion: Vec<[f64; 16]>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

impl SundogObject {
    /// What shader graphs may ask.
    pub(super) fn info(&self) -> ObjectInfo {
        let plain = ObjectInfo::default();
        ObjectInfo {
            color: self.color.unwrap_or(plain.color),
            index: self.pass_index.unwrap_or(plain.index),
            random: self.random.unwrap_or(plain.random),
            asset: self.asset.as_deref().map(Into::into),
            links: self.links.links(),
            values: self.values.clone().into(),
            shading_offset: self
                .shading_offset
                .filter(|offset| (0.0..=1.0).contains(offset))
                .unwrap_or(plain.shading_offset),
            reach: if self.fast_gi_distance.is_finite() {
                self.fast_gi_distance.max(0.0)
            } else {
                plain.reach
            },
            own_mesh: self.own_mesh,
        }
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct LightReference {
    pub light: usize,
}

#[derive(Debug, Deserialize)]
pub(super) struct VisibilityJson {
    #[serde(default = "yes")]
    pub visible: bool,
}

fn yes() -> bool {
    true
}

#[derive(Debug, Deserialize)]
pub(super) struct InstancingJson {
    #[serde(default)]
    pub attributes: InstancingAttributes,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct InstancingAttributes {
    pub translation: Option<usize>,
    pub rotation: Option<usize>,
    pub scale: Option<usize>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SkinJson {
    pub inverse_bind_matrices: Option<usize>,
    #[serde(default)]
    pub joints: Vec<usize>,
}

#[derive(Debug, Deserialize)]
pub(super) struct LightJson {
    pub name: Option<String>,
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default = "white")]
    pub color: [f32; 3],
    #[serde(default = "one")]
    pub intensity: f64,
    pub range: Option<f64>,
    pub spot: Option<SpotJson>,
    #[serde(default)]
    pub extensions: LightExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct LightExtensions {
    #[serde(rename = "SUNDOG_light")]
    pub sundog: Option<SundogLight>,
}

/// What KHR_lights_punctual has no word for. See `docs/gltf-extensions.md`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct SundogLight {
    /// On a node: `area`.
    #[serde(rename = "type")]
    pub kind: Option<String>,
    /// For messages.
    pub name: Option<String>,
    /// W/sr or W/m² in the place of colour and intensity; the colour of area lights.
    pub strength: Option<[f32; 3]>,
    /// Point and spot: radius of the sphere, metres.
    pub radius: Option<f64>,
    /// Point and spot: a disc that faces what it shines on.
    #[serde(default)]
    pub soft_falloff: bool,
    /// Spot: half the opening angle, radians.
    pub half_angle: Option<f64>,
    /// Spot: Blender's "Blend".
    pub blend: Option<f64>,
    /// Directional: angular diameter, radians.
    pub angle: Option<f64>,
    /// Area: `rectangle` or `ellipse`.
    pub shape: Option<String>,
    /// Area: full extents, metres.
    pub size: Option<[f64; 2]>,
    /// Area: watts.
    pub power: Option<f64>,
    /// Area: the power does not depend on the area.
    pub normalize: Option<bool>,
    /// The node tree that it is multiplied with.
    pub shader_graph: Option<Value>,
    /// Area: full angle, radians.
    pub spread: Option<f64>,
    /// Which rays see it.
    #[serde(default)]
    pub visibility: RaysJson,
    /// Paths with more bounces do not see it.
    pub max_bounces: Option<u32>,
    #[serde(flatten)]
    pub links: LinksJson,
    /// Whether scattered rays find it.
    pub mis: Option<bool>,
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

/// What a light or an object belongs to.
#[derive(Debug, Default, Deserialize)]
pub(super) struct LinksJson {
    light_group: Option<String>,
    lit_sets: Option<Vec<u8>>,
    shadow_sets: Option<Vec<u8>>,
    #[serde(default)]
    receiver_set: u8,
    #[serde(default)]
    blocker_set: u8,
    shadow_catcher: Option<bool>,
}

impl LinksJson {
    /// As the scene has it. Sets that there are not are the first one, as in Cycles.
    pub(super) fn links(&self) -> Links {
        let known = |set: u8, count: u8| if set < count { set } else { 0 };
        let sets = |list: &Option<Vec<u8>>, count: u8| {
            let bits = list.as_ref()?.iter().filter(|&&set| set < count);
            Some(bits.fold(0, |all, set| all | 1 << set))
        };
        Links {
            group: self.light_group.as_deref().map(Into::into),
            lit_sets: sets(&self.lit_sets, Links::RECEIVER_SETS).unwrap_or(u64::MAX),
            shadow_sets: sets(&self.shadow_sets, Links::BLOCKER_SETS).unwrap_or(u64::MAX),
            receiver_set: known(self.receiver_set, Links::RECEIVER_SETS),
            blocker_set: known(self.blocker_set, Links::BLOCKER_SETS),
            shadow_catcher: self.shadow_catcher,
        }
    }
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

pub(super) fn one() -> f64 {
    1.0
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SpotJson {
    #[serde(default)]
    pub inner_cone_angle: f64,
    #[serde(default = "quarter_pi")]
    pub outer_cone_angle: f64,
}

impl Default for SpotJson {
    fn default() -> Self {
        Self {
            inner_cone_angle: 0.0,
            outer_cone_angle: quarter_pi(),
        }
    }
}

fn quarter_pi() -> f64 {
    std::f64::consts::FRAC_PI_4
}

impl NodeJson {
    /// Reads each node once, so that an error in one that nothing reaches is told as well. They are not kept: a node of
    /// three bytes would take a thousand.
    pub(super) fn check_all(value: &Value) -> Result<usize, String> {
        each::<Self>(value, "/nodes", |_| ())
    }
}

impl Graph {
    /// Reads what it needs from the whole file's JSON; an error names the place.
    pub(super) fn parse(value: &Value) -> Result<Self, String> {
        Ok(Self {
            scene: optional(value, "/scene")?,
            scenes: list(value, "/scenes")?,
            cameras: list(value, "/cameras")?,
            skins: list(value, "/skins")?,
            lights: list(value, "/extensions/KHR_lights_punctual/lights")?,
            extensions_required: list(value, "/extensionsRequired")?,
        })
    }
}

fn optional<'de, T: Deserialize<'de>>(
    value: &'de Value,
    pointer: &str,
) -> Result<Option<T>, String> {
    match value.pointer(pointer) {
        None | Some(Value::Null) => Ok(None),
        Some(part) => T::deserialize(part)
            .map(Some)
            .map_err(|e| format!("{}: {}", &pointer[1..], words::plain(&e))),
    }
}

fn list<'de, T: Deserialize<'de>>(value: &'de Value, pointer: &str) -> Result<Vec<T>, String> {
    let mut items = Vec::new();
    each(value, pointer, |item| items.push(item))?;
    Ok(items)
}

/// Reads the items of a list one by one, and says how many there are.
fn each<'de, T: Deserialize<'de>>(
    value: &'de Value,
    pointer: &str,
    mut take: impl FnMut(T),
) -> Result<usize, String> {
    let items = match value.pointer(pointer) {
        None | Some(Value::Null) => return Ok(0),
        Some(Value::Array(items)) => items,
        Some(_) => return Err(format!("{} is not a list", &pointer[1..])),
    };
    for (i, item) in items.iter().enumerate() {
        take(T::deserialize(item).map_err(|e| {
            let name = item.get("name").and_then(Value::as_str);
            let name = name.map_or_else(String::new, |name| format!(" of \"{name}\""));
            format!("{}[{i}]{name}: {}", &pointer[1..], words::plain(&e))
        })?);
    }
    Ok(items.len())
}
