use super::*;

const STAGE: &str = "(\n metersPerUnit = 1\n upAxis = \"Y\"\n)\n";

/// What a text becomes, beside some other files.
fn read(text: &str, beside: &[(&str, &str)]) -> Result<Imported, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, contents) in beside {
        std::fs::write(folder.path().join(name), contents).unwrap();
    }
    let path = folder.path().join("scene.usda");
    std::fs::write(&path, text).unwrap();
    load(&path, &ImportOptions::default()).map_err(|error| error.to_string())
}

fn stage(prims: &str) -> Imported {
    read(&format!("#usda 1.0\n{STAGE}{prims}"), &[]).unwrap()
}

fn messages(imported: &Imported) -> String {
    let all = imported.diagnostics.iter();
    all.map(|d| d.to_string() + "\n").collect()
}

/// The library follows each of these without an end.
#[test]
fn prims_that_inherit_in_circles_are_composed() {
    let class = "class \"_c\" { def Xform \"r\" { def Sphere \"s\" {} } }\n";
    let again = |arc: &str| {
        format!("{class}def \"b\" ({arc} = </_c>) {{ over \"r\" ({arc} = </_c/r>) {{}} }}")
    };
    for (text, spheres) in [
        (again("inherits"), 1),
        (again("specializes"), 1),
        (
            "def Xform \"A\" (inherits = </A>) { def Sphere \"s\" {} def Sphere \"t\" {} }".into(),
            2,
        ),
        (
            "def Xform \"A\" (inherits = </B>) { def Sphere \"s\" {} }\ndef Xform \"B\" (inherits = </A>) { def Sphere \"t\" {} }".into(),
            3,
        ),
    ] {
        let imported = stage(&text);
        assert_eq!(imported.scene.instances.len(), spheres, "{text}");
        assert!(messages(&imported).contains("inherit"), "{text}");
    }
}

#[test]
fn statements_that_are_not_understood_are_left_out_and_named() {
    let imported = stage("def Sphere \"s\" {\n float a = undefined\n double radius = 2\n}");
    assert_eq!(imported.scene.instances.len(), 1);
    let told = messages(&imported);
    assert!(told.contains("scene.usda, line 7: float a"), "{told}");
    let refused = read("#usda 1.0\ndef Sphere {\n}", &[]).unwrap_err();
    assert!(
        refused.ends_with("its line 2 is not understood: \"def Sphere {\""),
        "{refused}"
    );
}

#[test]
fn layers_that_are_referred_to_are_read_as_well() {
    let part = "#usda 1.0\n(\n defaultPrim = \"p\"\n)\ndef Xform \"p\" {\n def Sphere \"s\" {\n  float a = undefined\n }\n}";
    let scene = format!("#usda 1.0\n{STAGE}def \"x\" (references = @part.usda@) {{}}");
    let imported = read(&scene, &[("part.usda", part)]).unwrap();
    assert_eq!(imported.scene.instances.len(), 1);
    assert!(messages(&imported).contains("part.usda, line 7: float a"));
}

#[test]
fn files_of_other_kinds_are_told_apart() {
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n";
    let refused = read(pointer, &[]).unwrap_err();
    assert!(refused.contains("git lfs pull"), "{refused}");
    let scene = |name: &str| {
        format!(
            "#usda 1.0\n{STAGE}def \"x\" (references = @{name}@</M>) {{}}\ndef Sphere \"s\" {{}}"
        )
    };
    for (name, told) in [
        ("part.usda", "git lfs pull"),
        ("m.mtlx", "MaterialX document and not read"),
        ("https://example.org/a.usda", "lies on the network"),
        ("absent.usda", "is not there"),
    ] {
        let beside = [("part.usda", pointer), ("m.mtlx", "<materialx/>")];
        let imported = read(&scene(name), &beside).unwrap();
        let all = messages(&imported);
        assert!(all.contains(told) && all.contains(name), "{all}");
        assert_eq!(imported.scene.instances.len(), 1);
    }
}

/// A prim without a kind is neither hidden nor placed by what it says, and a scope is not placed.
#[test]
fn prims_that_cannot_be_seen_or_placed_are_not() {
    let moved = "double3 xformOp:translate = (5, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n";
    let of = |prim: &str, words: &str| {
        let imported = stage(&format!(
            "def {prim} \"W\" {{\n {words}\n def Sphere \"s\" {{\n }}\n}}"
        ));
        let placed = imported.scene.instances.first();
        placed.map(|i| i.world_from_object.translation.x)
    };
    assert_eq!(of("", "token visibility = \"invisible\""), Some(0.0));
    assert_eq!(of("", "token purpose = \"proxy\""), Some(0.0));
    assert_eq!(of("", moved), Some(0.0));
    assert_eq!(of("Scope", moved), Some(0.0));
    assert_eq!(of("Scope", "token visibility = \"invisible\""), None);
    assert_eq!(of("Xform", "token purpose = \"proxy\""), None);
    assert_eq!(of("Xform", moved), Some(5.0));
}

/// Blender 3.x wrote a hundredth of a lamp's watts.
#[test]
fn lamps_of_old_releases_of_blender_have_their_watts() {
    let strength = |doc: &str, words: &str| {
        let text = format!(
            "#usda 1.0\n(\n doc = \"{doc}\"\n metersPerUnit = 1\n upAxis = \"Z\"\n)\ndef SphereLight \"l\" {{\n float inputs:radius = 0.1\n {words}\n}}"
        );
        let imported = read(&text, &[]).unwrap();
        match imported.scene.lights[0].kind {
            crate::scene::LightKind::Point { intensity, .. } => intensity,
            _ => panic!(),
        }
    };
    let old = strength("Blender v3.0.0", "float inputs:intensity = 10");
    let new = strength(
        "Blender v4.2.0",
        "float inputs:intensity = 318.30988\n bool inputs:normalize = 1",
    );
    assert!((old / new - 1.0).abs() < 1e-6, "{old} {new}");
}

#[test]
fn a_package_in_a_package_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("outer.usdz");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    zip.start_file("inner.usdz", options).unwrap();
    std::io::Write::write_all(&mut zip, b"PK").unwrap();
    zip.finish().unwrap();
    let refused = load(&path, &ImportOptions::default());
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.contains("its first file \"inner.usdz\" is a .usdz, and packages"),
        "{refused}"
    );
}

/// Packages as USD's own packer makes them: what a nested layer names may be told from the package's root.
#[test]
fn packed_layers_name_files_from_the_root() {
    let scene = format!("#usda 1.0\n{STAGE}def \"x\" (references = @0/mid.usda@) {{}}");
    let mid = "#usda 1.0\n(\n defaultPrim = \"p\"\n)\ndef \"p\" (references = @1/geo.usda@) {}";
    let geo = "#usda 1.0\n(\n defaultPrim = \"p\"\n)\ndef Sphere \"p\" {}";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.usdz");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let parts = [
        ("a.usda", &*scene),
        ("0/mid.usda", mid),
        ("1/geo.usda", geo),
    ];
    for (name, text) in parts {
        zip.start_file(name, options).unwrap();
        std::io::Write::write_all(&mut zip, text.as_bytes()).unwrap();
    }
    zip.finish().unwrap();
    let imported = load(&path, &ImportOptions::default()).unwrap();
    assert_eq!(imported.scene.instances.len(), 1, "{}", messages(&imported));
}

#[test]
fn names_in_other_capitals_are_hinted_at() {
    let scene = format!("#usda 1.0\n{STAGE}def \"x\" (references = @Part.usda@) {{}}");
    let told = messages(&read(&scene, &[("part.usda", "#usda 1.0")]).unwrap());
    let hint = "is not there, but \"part.usda\" is: capitals and small letters count";
    assert!(told.contains(hint), "{told}");
}

const VARIANTS: &str = r#"
def "a" (
    variants = { string shape = "round" }
    prepend variantSets = "shape"
)
{
    variantSet "shape" = {
        "round" { def Sphere "s" {} }
        "square" (
            variants = { string count = "one" }
            prepend variantSets = "count"
        ) {
            variantSet "count" = {
                "one" { def Cube "c" {} }
                "two" { def Cube "c" {}  def Cube "d" {} }
            }
        }
    }
}"#;

/// A set that another one's variant brings is there once that is chosen.
#[test]
fn variants_in_variants_are_chosen() {
    let chosen = |wanted: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.usda");
        std::fs::write(&path, format!("#usda 1.0\n{STAGE}{VARIANTS}")).unwrap();
        let options = ImportOptions {
            variant: Some(wanted.into()),
            ..ImportOptions::default()
        };
        load(&path, &options)
            .map(|imported| imported.scene.instances.len())
            .map_err(|error| error.to_string())
    };
    assert_eq!(chosen("shape=square,count=two"), Ok(2));
    assert_eq!(chosen("count=two, shape=square"), Ok(2));
    assert_eq!(chosen("shape=square"), Ok(1));
    let refused = chosen("shape=square,count=three").unwrap_err();
    assert!(refused.contains("count=one, count=two"), "{refused}");
    assert!(chosen("count=two").is_err());
}

const SQUARE: &str = r#"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
"#;

#[test]
fn a_network_that_is_not_read_is_named_beside_a_preview() {
    let imported = stage(&format!(
        r#"def Mesh "m" {{
    rel material:binding = </M>
{SQUARE}}}
def Material "M" {{
    token outputs:surface.connect = </M/p.outputs:surface>
    token outputs:mtlx:surface.connect = </M/s.outputs:out>
    def Shader "p" {{
        uniform token info:id = "UsdPreviewSurface"
    }}
    def Shader "s" {{
        uniform token info:id = "ND_standard_surface_surfaceshader"
        color3f inputs:base_color.connect = </M/n.outputs:out>
    }}
    def Shader "n" {{
        uniform token info:id = "ND_unheard_of_color3"
    }}
}}"#
    ));
    let told = messages(&imported);
    assert!(told.contains("ND_unheard_of_color3"), "{told}");
    assert!(told.contains("MaterialX networks with nodes"), "{told}");
}

/// Names of collections are paths of names: the library takes those alone that are one.
#[test]
fn collections_with_colons_in_their_names_bind() {
    let imported = stage(&format!(
        r#"over "C" (
    prepend apiSchemas = ["CollectionAPI:material:Main"]
)
{{
    uniform token collection:material:Main:expansionRule = "expandPrims"
    rel collection:material:Main:includes = </S/m>
}}
def Scope "S" {{
    rel material:binding:collection:preview:Main = [</C.collection:material:Main>, </S/M>]
    def Material "M" {{
        token outputs:surface.connect = </S/M/p.outputs:surface>
        def Shader "p" {{
            uniform token info:id = "UsdPreviewSurface"
        }}
    }}
    def Mesh "m" {{
{SQUARE}    }}
}}"#
    ));
    let bound = &imported.scene.materials[0].name;
    assert_eq!(bound, "M");
}

/// Neither visibility nor purposes are of cameras.
#[test]
fn render_settings_name_their_camera_whatever_hides_it() {
    let prims = |product: &str, camera: &str| {
        format!(
            r#"def Camera "First" {{
}}
def Xform "group" {{
    token visibility = "invisible"
    def Camera "Shot" {{
        uniform token purpose = "guide"
        float fStop = 2
        float focusDistance = 3
    }}
    def Sphere "s" {{
    }}
}}
def RenderSettings "rs" {{
    uniform int2 resolution = (64, 32)
    rel camera = <{camera}>
    rel products = </product>
}}
def RenderProduct "product" {{
{product}
}}"#
        )
    };
    let imported = stage(&prims("", "/group/Shot"));
    let scene = &imported.scene;
    assert_eq!(scene.instances.len(), 0);
    assert_eq!(scene.cameras.len(), 2);
    assert_eq!(scene.cameras[0].name, "Shot");
    assert!(scene.cameras[0].aperture.is_some());
    assert_eq!(scene.render.width, Some(64));
    let overrides = "uniform int2 resolution = (40, 20)\nrel camera = </First>\nuniform bool disableDepthOfField = 1\nuniform float pixelAspectRatio = 2";
    let imported = stage(&prims(overrides, "/group/Shot"));
    let scene = &imported.scene;
    assert_eq!(scene.cameras[0].name, "First");
    assert!(scene.cameras.iter().all(|camera| camera.aperture.is_none()));
    assert_eq!(
        (scene.render.width, scene.render.height),
        (Some(40), Some(20))
    );
    assert!(messages(&imported).contains("pixels that are not square"));
    let told = messages(&stage(&prims("", "/nowhere")));
    assert!(
        told.contains("camera of the render settings that is not there"),
        "{told}"
    );
}

/// A square with a material, whose surface has these inputs, beside other prims.
fn painted(primvars: &str, inputs: &str, others: &str) -> Imported {
    stage(&format!(
        r#"def Mesh "m" {{
    rel material:binding = </M>
{primvars}
{SQUARE}}}
def Material "M" {{
    token outputs:surface.connect = </M/p.outputs:surface>
    token outputs:displacement.connect = </M/p.outputs:displacement>
    def Shader "p" {{
        uniform token info:id = "UsdPreviewSurface"
{inputs}
    }}
{others}
}}"#
    ))
}

#[test]
fn displacement_is_lost_once_and_only_where_there_is_some() {
    for (inputs, count) in [
        ("", 0),
        ("float inputs:displacement = 0", 0),
        ("float inputs:displacement = 0.2", 1),
    ] {
        let told = messages(&painted("", inputs, ""));
        assert_eq!(told.matches("displacement").count(), count, "{told}");
    }
}

/// The reader's own value stands for coordinates that a mesh does not have, other ones do not.
#[test]
fn readers_of_coordinates_have_fallbacks() {
    let imported = painted(
        "texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = \"vertex\")",
        "color3f inputs:diffuseColor.connect = </M/t.outputs:rgb>",
        r#"    def Shader "t" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @none.png@
        float2 inputs:st.connect = </M/r.outputs:result>
    }
    def Shader "r" {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "elsewhere"
        float2 inputs:fallback = (0.25, 0.75)
    }"#,
    );
    let uvs = &imported.scene.meshes[0].uvs;
    assert!(
        uvs.iter().flatten().all(|uv| *uv == [0.25, 0.25]),
        "{uvs:?}"
    );
}

#[test]
fn constant_values_from_above_keep_their_indices() {
    let imported = stage(&format!(
        r#"def Xform "x" {{
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)]
    int[] primvars:displayColor:indices = [1]
    def Mesh "m" {{
{SQUARE}    }}
}}"#
    ));
    let colors = imported.scene.meshes[0].colors.as_ref().unwrap();
    assert_eq!(colors[0], [0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn what_is_not_read_is_named() {
    let told = messages(&stage(
        r#"def Mesh "m" {
    int[] faceVertexCounts = [4, 3]
    int[] faceVertexIndices = [0, 1, 2, 3, 9]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
    rel material:binding:collection:some = [</m.collection:some>, </M>]
    uniform string collection:some:membershipExpression = "//"
}
def SphereLight "l" {
    float inputs:shaping:focus = 5
    color3f inputs:shaping:focusTint = (1, 0, 0)
}"#,
    ));
    for what in [
        "1 face with corners that do not exist",
        "faceVertexCounts",
        "collections by expressions",
        "focusTint",
    ] {
        assert!(told.contains(what), "{what}: {told}");
    }
}

/// In words of their own, not of the parsers'.
#[test]
fn files_that_are_none_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    for (name, contents, told) in [
        ("a.usda", "", "it is empty"),
        (
            "a.usda",
            "{\"asset\": {}}",
            "its first bytes are those of no USD file",
        ),
        ("a.usdz", "PK\u{3}\u{4}", "cut off or damaged"),
        ("a.glb", "#usda 1.0\n", "rename it to end in .usd"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, contents).unwrap();
        let error = load(&path, &ImportOptions::default()).unwrap_err();
        assert!(error.to_string().contains(told), "{error}");
    }
}
