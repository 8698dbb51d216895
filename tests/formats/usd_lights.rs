//! UsdLux measured: what each light gives a plane, beside what its definition says.

use std::f64::consts::PI;

use sundog::render::{RenderSettings, Silent, render};
use sundog::scene::graph::node::diffuse;
use sundog::scene::graph::{Graph, Node, NodeKind};
use sundog::scene::{Material, Scene};

use super::usd::Stage;

/// A white floor, of which the camera sees a square of 1 mm about the origin, from right below the lights.
fn floor(lights: &str, files: &[(&str, Vec<u8>)]) -> Scene {
    let stage = Stage::new(&format!(
        r#"def Mesh "floor" {{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-9, 0, 9), (9, 0, 9), (9, 0, -9), (-9, 0, -9)]
    uniform token subdivisionScheme = "none"
}}
def Camera "above" {{
    uniform token projection = "orthographic"
    float horizontalAperture = 0.01
    float verticalAperture = 0.01
    float2 clippingRange = (0.001, 10)
    double3 xformOp:translate = (0, 0.1, 0)
    float xformOp:rotateX = -90
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
}}
{lights}"#
    ));
    for (name, bytes) in files {
        stage.file(name, bytes);
    }
    let imported = stage.load();
    for message in imported.diagnostics.iter() {
        assert!(!message.code.starts_with("light"), "{message:?}");
    }
    let mut scene = imported.scene;
    let floor = scene.meshes[0].material.unwrap();
    let mut graph = Graph::default();
    let white = Node::new(NodeKind::DiffuseBsdf {
        rules: Default::default(),
    })
    .with(diffuse::COLOR, [1.0; 3]);
    graph.surface = Some(graph.add(white));
    scene.materials[floor.0 as usize] = Material {
        name: "white".into(),
        graph,
        double_sided: true,
        medium: None,
        priority: None,
    };
    scene
}

/// Irradiance on the floor, W/m².
fn irradiance(lights: &str) -> [f64; 3] {
    irradiance_with(lights, &[])
}

fn irradiance_with(lights: &str, files: &[(&str, Vec<u8>)]) -> [f64; 3] {
    let settings = RenderSettings {
        width: 8,
        height: 8,
        samples: 1024,
        bounces: 1,
        ..RenderSettings::default()
    };
    let rendering = render(&floor(lights, files), &settings, &Silent).unwrap();
    let pixels = &rendering.picture.layers[0].data;
    let mut sum = [0.0; 3];
    for pixel in pixels.chunks(4) {
        for (sum, value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(*value);
        }
    }
    // A white diffuse surface gives its irradiance by π.
    sum.map(|v| v * PI / (pixels.len() / 4) as f64)
}

/// A light one metre above the floor that looks down, tilted about Z.
fn above(kind: &str, tilt: f64, inputs: &str) -> String {
    format!(
        r#"def {kind} "lamp" (
    prepend apiSchemas = ["ShapingAPI"]
)
{{
    double3 xformOp:translate = (0, 1, 0)
    float xformOp:rotateZ = {tilt}
    float xformOp:rotateX = -90
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ", "xformOp:rotateX"]
    {inputs}
}}"#
    )
}

/// Within a thousandth. 65,536 samples in a low-discrepancy order: what a light gives varies by less than its mean across it, so
/// that even independent samples would be off by less than 1/√65536 = 0.4 % of that deviation; those of Sobol' are far nearer.
fn holds(lights: &str, expected: f64) {
    holds_with(lights, &[], expected);
}

fn holds_with(lights: &str, files: &[(&str, Vec<u8>)], expected: f64) {
    for value in irradiance_with(lights, files) {
        assert!(
            (value - expected).abs() <= 1e-3 * expected,
            "{value} and not {expected}: {lights}"
        );
    }
}

/// Nusselt's analog: a sphere of radius r at the distance h covers (r/h)² of the disc.
#[test]
fn spheres() {
    let of = |inputs: &str| above("SphereLight", 0.0, inputs);
    holds(
        &of("float inputs:radius = 0.25\n float inputs:intensity = 3"),
        3.0 * PI / 16.0,
    );
    let normalized =
        "float inputs:radius = 0.25\n float inputs:intensity = 3\n bool inputs:normalize = 1";
    // 3 / (4π r²) of radiance.
    holds(&of(normalized), 3.0 / 4.0);
    holds(
        &of("float inputs:radius = 0.25\n float inputs:exposure = 2.5"),
        2f64.powf(2.5) * PI / 16.0,
    );
    // A point with the power of the sphere that it stands for.
    let point = "float inputs:radius = 0.1\n bool treatAsPoint = 1\n float inputs:intensity = 3";
    holds(&of(point), 3.0 * PI * 0.01);
    holds(
        &of(&format!("{point}\n bool inputs:normalize = 1")),
        3.0 / 4.0,
    );
}

#[test]
fn disks_and_rectangles() {
    let disk = "float inputs:radius = 0.5\n float inputs:intensity = 2";
    holds(&above("DiskLight", 0.0, disk), 2.0 * PI * 0.25 / 1.25);
    let normalized = format!("{disk}\n bool inputs:normalize = 1");
    holds(&above("DiskLight", 0.0, &normalized), 2.0 / 1.25);
    // Four corners, each of a quarter (Howell's catalogue of configuration factors, B-4).
    let corner = |x: f64, y: f64| {
        let far = |a: f64| glam::DVec2::new(a, 1.0).length();
        let of = |a: f64, b: f64| a / far(a) * (b / far(a)).atan();
        (of(x, y) + of(y, x)) / (2.0 * PI)
    };
    let expected = 2.0 * PI * 4.0 * corner(0.4, 0.7);
    let rect = "float inputs:width = 0.8\n float inputs:height = 1.4\n float inputs:intensity = 2";
    holds(&above("RectLight", 0.0, rect), expected);
    let normalized = format!("{rect}\n bool inputs:normalize = 1");
    holds(
        &above("RectLight", 0.0, &normalized),
        expected / (0.8 * 1.4),
    );
    // From behind there is nothing.
    assert_eq!(irradiance(&above("RectLight", 180.0, rect)), [0.0; 3]);
}

/// The integral over the side that is seen, by the midpoint rule; the polygon of 128 sides is narrower by 0.01 %.
#[test]
fn cylinders() {
    let (radius, length) = (0.2, 1.0);
    let steps = 1000;
    let mut sum = 0.0;
    for i in 0..steps {
        let angle = 2.0 * PI * (f64::from(i) + 0.5) / f64::from(steps);
        let (sin, cos) = angle.sin_cos();
        for j in 0..steps {
            let x = length * ((f64::from(j) + 0.5) / f64::from(steps) - 0.5);
            let place = glam::DVec3::new(x, 1.0 + radius * sin, radius * cos);
            let square = place.length_squared();
            let facing = -place.dot(glam::DVec3::new(0.0, sin, cos));
            if facing > 0.0 {
                sum += facing * place.y / (square * square);
            }
        }
    }
    let area = 2.0 * PI * radius * length;
    let expected = sum * area / f64::from(steps * steps);
    let inputs = "float inputs:radius = 0.2\n float inputs:length = 1";
    holds(&above("CylinderLight", 0.0, inputs), expected);
    let normalized = format!("{inputs}\n bool inputs:normalize = 1");
    holds(&above("CylinderLight", 0.0, &normalized), expected / area);
}

#[test]
fn distant_lights_and_domes() {
    for (angle, tilt) in [(0.0f64, 0.0f64), (0.53, 60.0), (20.0, 30.0)] {
        let inputs = format!("float inputs:angle = {angle}\n float inputs:intensity = 5");
        let facing = tilt.to_radians().cos();
        let normalized = format!("{inputs}\n bool inputs:normalize = 1");
        holds(&above("DistantLight", tilt, &normalized), 5.0 * facing);
        let size = PI * (angle / 2.0).to_radians().sin().powi(2);
        let expected = if angle > 0.0 {
            5.0 * size * facing
        } else {
            5.0 * facing
        };
        holds(&above("DistantLight", tilt, &inputs), expected);
    }
    holds(
        &above("DomeLight", 0.0, "float inputs:intensity = 0.5"),
        0.5 * PI,
    );
}

/// A small sphere whose axis is tilted: what its cone and its focus leave in the direction of the floor.
#[test]
fn cones_and_focus() {
    let of = |tilt: f64, more: &str| {
        let inputs = format!(
            "float inputs:radius = 0.001\n bool inputs:normalize = 1\n float inputs:intensity = 4\n {more}"
        );
        above("SphereLight", tilt, &inputs)
    };
    let cone = "float inputs:shaping:cone:angle = 40";
    holds(&of(39.0, cone), 1.0);
    assert_eq!(irradiance(&of(41.0, cone)), [0.0; 3]);
    // From 20° to 40° a smooth step; in its middle a half.
    let soft = format!("{cone}\n float inputs:shaping:cone:softness = 0.5");
    holds(&of(19.0, &soft), 1.0);
    holds(&of(30.0, &soft), 0.5);
    let t = (35.0 - 20.0) / 20.0f64;
    holds(&of(35.0, &soft), 1.0 - t * t * (3.0 - 2.0 * t));
    let focus = "float inputs:shaping:focus = 3";
    holds(&of(50.0, focus), 50f64.to_radians().cos().powi(3));
}

/// Each channel by the colour of `UsdLux.BlackbodyTemperatureAsRgb` of usd-core 26.11.
#[test]
fn temperatures() {
    let inputs = "float inputs:radius = 0.25\n bool inputs:enableColorTemperature = 1\n float inputs:colorTemperature = 2856";
    let found = irradiance(&above("SphereLight", 0.0, inputs));
    for (value, color) in found.iter().zip([1.845_254, 0.826_112, 0.233_570]) {
        let expected = color * PI / 16.0;
        assert!((value - expected).abs() <= 1e-3 * expected, "{found:?}");
    }
}

/// Candela of 2 downwards and 6 at the side; tilted by 45° it is 4 in between, on a curve that is straight there.
#[test]
fn ies_profiles() {
    let text =
        "IESNA:LM-63-1995\nTILT=NONE\n1 -1 2 5 1 1 2 0 0 0\n1 1 0\n0 45 90 135 180\n0\n1 2 3 4 5\n";
    let files = [("lamp.ies", text.as_bytes().to_vec())];
    let of = |tilt: f64, more: &str| {
        let inputs = format!(
            "float inputs:radius = 0.001\n bool inputs:normalize = 1\n float inputs:intensity = 4\n asset inputs:shaping:ies:file = @./lamp.ies@\n {more}"
        );
        above("SphereLight", tilt, &inputs)
    };
    holds_with(&of(0.0, ""), &files, 2.0);
    holds_with(&of(45.0, ""), &files, 4.0);
    holds_with(&of(90.0, ""), &files, 6.0);
    // The mean over the sphere of what rises with the angle from 2 to 10 is 6.
    let normalized = "bool inputs:shaping:ies:normalize = 1";
    holds_with(&of(90.0, normalized), &files, 1.0);
    // Half of the angles: what was at 90° is at 45°.
    holds_with(
        &of(45.0, "float inputs:shaping:ies:angleScale = 0.5"),
        &files,
        6.0,
    );
}

/// Upright for who looks at the front: the left half of the image is on +X.
#[test]
fn images_on_rectangles() {
    let image = |left: u8, right: u8| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let pixels = [left, left, right, right].map(|v| [v; 3]).concat();
        let image = image::RgbImage::from_raw(4, 1, pixels).unwrap();
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let lamp = r#"def RectLight "lamp" {
    double3 xformOp:translate = (-0.45, 0.05, 0)
    float xformOp:rotateX = -90
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
    asset inputs:texture:file = @./image.png@
}"#;
    let of = |left, right| irradiance_with(lamp, &[("image.png", image(left, right))])[0];
    let white = of(255, 255);
    let plain = irradiance(&lamp.replace("asset inputs", "asset user"))[0];
    assert!((white / plain - 1.0).abs() < 1e-3, "{white} {plain}");
    let (left, right) = (of(255, 0), of(0, 255));
    assert!(
        left > 0.97 * white && right < 0.03 * white,
        "{left} {right} {white}"
    );
    // Between the halves, encoded values are blended, as in Cycles.
    assert!(((left + right) / white - 1.0).abs() < 1e-2);
}

/// A plate between the lamp and the floor: who is lit, and who casts shadows.
#[test]
fn lights_are_linked() {
    let of = |links: &str| {
        let lamp = above(
            "SphereLight",
            0.0,
            &format!(
                "float inputs:radius = 0.01\n bool inputs:normalize = 1\n float inputs:intensity = 4\n {links}"
            ),
        );
        format!(
            r#"{lamp}
def Xform "group" {{
    def Mesh "plate" {{
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-0.1, 0.5, 0.1), (0.1, 0.5, 0.1), (0.1, 0.5, -0.1), (-0.1, 0.5, -0.1)]
        uniform token subdivisionScheme = "none"
    }}
}}"#
        )
    };
    assert_eq!(irradiance(&of("")), [0.0; 3]);
    holds(&of("rel collection:shadowLink:excludes = </group>"), 1.0);
    let lists = |link: &str, prim: &str| {
        of(&format!(
            "uniform bool collection:{link}:includeRoot = 0\n rel collection:{link}:includes = <{prim}>\n rel collection:shadowLink:excludes = </group/plate>"
        ))
    };
    holds(&lists("lightLink", "/floor"), 1.0);
    assert_eq!(irradiance(&lists("lightLink", "/group")), [0.0; 3]);
}
