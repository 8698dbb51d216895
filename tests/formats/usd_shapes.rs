//! What USD's skeletons, curves, points and instancers become.

use glam::DVec3;
use sundog::import::{self, AnimationTime, ImportOptions, Imported};
use sundog::scene::Verdict;

use super::usd::{SQUARE, Stage, places, told};

fn at_frame(path: &std::path::Path, frame: f64) -> Imported {
    let animation = Some(AnimationTime {
        name: None,
        seconds: 0.0,
        frame: Some(frame),
    });
    let options = ImportOptions {
        animation,
        ..ImportOptions::default()
    };
    import::load(path, &options).unwrap()
}

/// Points and normals of the one placed mesh, in the world.
fn placed(imported: &Imported) -> (Vec<DVec3>, Vec<DVec3>) {
    let instance = &imported.scene.instances[0];
    let mesh = &imported.scene.meshes[instance.mesh.0 as usize];
    let world = instance.world_from_object;
    let wide = |v: &[f32; 3]| DVec3::from(v.map(f64::from));
    let points = mesh
        .positions
        .iter()
        .map(|p| world.transform_point3(wide(p)));
    let turned = |n: &[f32; 3]| world.transform_vector3(wide(n)).normalize();
    let normals = mesh.normals.as_ref().unwrap().iter().map(turned);
    (points.collect(), normals.collect())
}

/// `UsdSkel.BakeSkinning` of usd-core 26.11 says where the points are: joints in another order than the skeleton's, a joint that
/// the animation leaves out, blend shapes with a shape between, a mesh whose own place does not count.
#[test]
fn skeletons_pose_meshes_as_usd_does() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.usda");
    std::fs::write(&path, include_str!("usd_skeleton.usda")).unwrap();
    let expected = [
        (
            1.0,
            [
                [1.25, 2.5, 3.43301],
                [2.11603, 2.0, 2.93301],
                [2.40978, 5.5, 3.4418],
                [1.375, 5.58, 3.64952],
            ],
        ),
        (
            3.0,
            [
                [1.44748, 2.30866, 3.27505],
                [3.26921, 2.6411, 2.38228],
                [1.86875, 5.75381, 5.4139],
                [0.69629, 4.75933, 5.19334],
            ],
        ),
        (
            5.0,
            [
                [1.60979, 2.14645, 3.05619],
                [4.08868, 3.20711, 2.84974],
                [-0.40399, 4.70087, 6.16823],
                [0.11183, 2.67678, 4.94165],
            ],
        ),
    ];
    for (frame, theirs) in expected {
        let imported = at_frame(&path, frame);
        let (points, normals) = placed(&imported);
        for (ours, theirs) in points.iter().zip(theirs) {
            // Their five digits, and half precision in the scales.
            let gap = (*ours - DVec3::from(theirs)).length();
            assert!(gap < 2e-5, "{frame}: {ours} {theirs:?}");
        }
        if frame == 5.0 {
            // The first three hang on joints that only turn, on which normals turn alike.
            let theirs = DVec3::new(0.35355, -std::f64::consts::FRAC_1_SQRT_2, 0.61237);
            assert!((normals[0] - theirs).length() < 2e-5, "{normals:?}");
        }
        assert_eq!(told(&imported, "usd-skeleton"), None);
    }
}

/// Half of what a skeleton needs is damaged, each in turn: the mesh is there, and something is told.
#[test]
fn broken_skeletons_are_told_and_do_no_harm() {
    let text = include_str!("usd_skeleton.usda");
    for (from, to) in [
        (
            "uniform matrix4d[] bindTransforms",
            "uniform matrix4d[] other",
        ),
        ("= </char/rig>", "= </char/none>"),
        (
            "int[] primvars:skel:jointIndices = [1, 0,",
            "int[] primvars:skel:jointIndices = [1,",
        ),
        ("pointIndices = [2, 3]", "pointIndices = [2, 300]"),
        (
            "quatf[] rotations.timeSamples = { 1: [(1, 0, 0, 0), ",
            "quatf[] rotations.timeSamples = { 1: [",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.usda");
        std::fs::write(&path, text.replace(from, to)).unwrap();
        let imported = at_frame(&path, 1.0);
        assert_eq!(imported.scene.instances.len(), 1, "{from}");
        assert!(told(&imported, "usd-skeleton").is_some(), "{from}");
    }
}

#[test]
fn curves_are_tubes_with_values_of_every_interpolation() {
    for (interpolation, values) in [
        ("constant", "[(0, 0.5, 0)]"),
        ("uniform", "[(0, 0.5, 0), (0, 0.5, 1)]"),
        (
            "varying",
            "[(0, 0.5, 0), (0, 0.5, 0), (0, 0.5, 1), (0, 0.5, 1)]",
        ),
        (
            "vertex",
            "[(0, 0.5, 0), (0, 0.5, 0), (0, 0.5, 0), (0, 0.5, 0), (0, 0.5, 1), (0, 0.5, 1), (0, 0.5, 1), (0, 0.5, 1)]",
        ),
    ] {
        let stage = Stage::new(&format!(
            r#"def BasisCurves "hair" {{
    uniform token type = "cubic"
    uniform token basis = "bspline"
    int[] curveVertexCounts = [4, 4]
    point3f[] points = [(0, 0, 0), (0, 1, 0), (0, 2, 0), (0, 3, 0), (5, 0, 0), (5, 1, 0), (5, 2, 0), (5, 3, 0)]
    float[] widths = [0.2]
    color3f[] primvars:displayColor = {values} (
        interpolation = "{interpolation}"
    )
}}"#
        ));
        let imported = stage.load();
        assert_eq!(told(&imported, "usd-curves"), Some(Verdict::Approximated));
        let mesh = &imported.scene.meshes[0];
        let colors = mesh.colors.as_ref().unwrap();
        for (point, color) in mesh.positions.iter().zip(colors) {
            // A straight spline from the second to the third point, 0.1 wide to each side.
            assert!((0.999..2.001).contains(&point[1]), "{point:?}");
            let middle = if point[0] > 2.5 { 5.0 } else { 0.0 };
            let radius = glam::Vec2::new(point[0] - middle, point[2]).length();
            assert!((0.1..0.103).contains(&radius), "{radius}");
            let blue = if middle > 0.0 && interpolation != "constant" {
                1.0
            } else {
                0.0
            };
            assert_eq!(*color, [0.0, 0.5, blue, 1.0], "{interpolation}");
        }
    }
}

#[test]
fn broken_curves_do_no_harm() {
    for body in [
        "int[] curveVertexCounts = [4, 2147483647, -5]\n point3f[] points = [(0, 0, 0)]",
        "int[] curveVertexCounts = [0, 1, 2, 3]\n point3f[] points = [(0, 0, 0), (nan, inf, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0)]\n uniform token wrap = \"periodic\"",
        "int[] curveVertexCounts = [2]\n point3f[] points = [(0, 0, 0), (0, 0, 0)]\n uniform token type = \"linear\"\n float[] widths = [nan]\n normal3f[] normals = [(0, 0, 0)]",
        "int[] curveVertexCounts = [3]",
    ] {
        for basis in ["bezier", "catmullRom", "bspline"] {
            let body = format!(
                "def BasisCurves \"c\" {{\n uniform token basis = \"{basis}\"\n {body}\n}}"
            );
            let _ = Stage::new(&body).load();
        }
    }
}

#[test]
fn points_are_spheres_with_sizes_and_colours() {
    let stage = Stage::new(
        r#"def Points "dots" {
    point3f[] points = [(1, 0, 0), (2, 0, 0), (3, 0, 0)]
    float[] widths = [1, 0, 4]
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1)] (
        interpolation = "vertex"
    )
}"#,
    );
    let imported = stage.load();
    assert_eq!(imported.scene.meshes.len(), 1);
    // Nothing is seen of what has no size.
    assert_eq!(places(&imported), [DVec3::X, DVec3::new(3.0, 0.0, 0.0)]);
    let instances = &imported.scene.instances;
    assert_eq!(instances[1].world_from_object.matrix3.x_axis.length(), 2.0);
    assert_eq!(instances[0].info.color, [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(instances[1].info.color, [0.0, 0.0, 1.0, 1.0]);
    let graph = format!("{:?}", imported.scene.materials[0].graph);
    assert!(graph.contains("ObjectColor"), "{graph}");
}

/// An instancer in an instancer; ids that are not active, and colours of its own for each.
#[test]
fn instancers_nest_hide_and_colour() {
    let stage = Stage::new(&format!(
        r#"def PointInstancer "outer" (
    inactiveIds = [11]
)
{{
    rel prototypes = </outer/inner>
    int[] protoIndices = [0, 0, 0]
    int64[] ids = [10, 11, 12]
    point3f[] positions = [(0, 0, 0), (10, 0, 0), (20, 0, 0)]
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1)] (
        interpolation = "varying"
    )
    def PointInstancer "inner" {{
        rel prototypes = </outer/inner/m>
        int[] protoIndices = [0, 0]
        point3f[] positions = [(0, 1, 0), (0, 2, 0)]
        def Mesh "m" {{
{SQUARE}        }}
    }}
}}"#
    ));
    let imported = stage.load();
    let expected = [[0.0, 1.0], [0.0, 2.0], [20.0, 1.0], [20.0, 2.0]];
    assert_eq!(
        places(&imported),
        expected.map(|[x, y]| DVec3::new(x, y, 0.0))
    );
    let colors: Vec<_> = imported
        .scene
        .instances
        .iter()
        .map(|i| i.info.color[2])
        .collect();
    assert_eq!(colors, [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(told(&imported, "usd-instance-colour"), None);
    // A colour of the mesh's own comes first, which is told.
    let own = "color3f[] primvars:displayColor = [(0.5, 0.5, 0.5)]\n int[] faceVertexCounts";
    let text = std::fs::read_to_string(stage.path()).unwrap();
    let imported = Stage::with(&text.replace("int[] faceVertexCounts", own)).load();
    assert_eq!(told(&imported, "usd-instance-colour"), Some(Verdict::Lost));
}

/// A volume with the density of an OpenVDB file, in its field's place.
fn volume(more: &str) -> Stage {
    Stage::new(&format!(
        r#"def Volume "smoke" {{
    rel field:density = </smoke/density>
    {more}
    double3 xformOp:translate = (0, 5, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def OpenVDBAsset "density" {{
        token fieldName = "density"
        asset filePath = @smoke.vdb@
        double3 xformOp:scale = (2, 2, 2)
        uniform token[] xformOpOrder = ["xformOp:scale"]
    }}
}}"#
    ))
}

#[test]
fn volumes_are_boxes_filled_with_their_density() {
    let file = include_bytes!("../unit/import/vdb/files/zip.vdb");
    let stage = volume("");
    stage.file("smoke.vdb", file);
    let imported = stage.load();
    assert_eq!(told(&imported, "usd-volume"), None);
    let instance = &imported.scene.instances[0];
    let mesh = &imported.scene.meshes[instance.mesh.0 as usize];
    let grids = mesh.grids.as_ref().unwrap();
    assert!(grids.density_by_object);
    let grid = grids.get(0).unwrap();
    let (low, high) = grid.active.unwrap();
    for (end, number) in [(low.as_dvec3() - 1.0, 0), (high.as_dvec3() + 1.0, 7)] {
        let corner = DVec3::from(mesh.positions[number].map(f64::from));
        let expected = grid.object_from_index.transform_point3(end);
        assert!((corner - expected).length() < 1e-4);
    }
    let material = &imported.scene.materials[mesh.material.unwrap().0 as usize];
    let medium = material.medium.as_ref().unwrap();
    assert!(medium.varying.as_ref().unwrap().volume.is_some());
    assert_eq!(
        instance.world_from_object.translation,
        DVec3::new(0.0, 5.0, 0.0)
    );
    // Its field is twice as large as the file has it.
    let plain = imported_plain(file);
    let ratio = grid.object_from_index.matrix3.x_axis.length() / plain;
    assert!((ratio - 2.0).abs() < 1e-9);
}

/// How far the file's points are apart along X.
fn imported_plain(file: &[u8]) -> f64 {
    let stage = Stage::new(
        "def Volume \"v\" {\n rel field:density = </v/d>\n def OpenVDBAsset \"d\" {\n asset filePath = @smoke.vdb@\n }\n}",
    );
    stage.file("smoke.vdb", file);
    let imported = stage.load();
    let grids = imported.scene.meshes[0].grids.clone().unwrap();
    grids
        .get(0)
        .unwrap()
        .object_from_index
        .matrix3
        .x_axis
        .length()
}

#[test]
fn volumes_that_cannot_be_read_are_told() {
    let missing = volume("").load();
    assert_eq!(told(&missing, "usd-volume"), Some(Verdict::Lost));
    assert!(missing.scene.instances.is_empty());
    for broken in [&b"no grid at all"[..], b"", b" BDV"] {
        let stage = volume("");
        stage.file("smoke.vdb", broken);
        assert_eq!(told(&stage.load(), "usd-volume"), Some(Verdict::Lost));
    }
    let stage = volume("rel field:heat = </smoke/density>");
    stage.file(
        "smoke.vdb",
        include_bytes!("../unit/import/vdb/files/zip.vdb"),
    );
    let imported = stage.load();
    assert_eq!(told(&imported, "usd-volume"), Some(Verdict::Lost));
    assert_eq!(imported.scene.instances.len(), 1);
}
