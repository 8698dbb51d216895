use super::*;
use crate::scene::graph::function::{Function, PlaceInput};
use crate::scene::graph::{Graph, Node, NodeKind};
use crate::scene::{Material, MaterialId, MeshId, ObjectInfo, Visibility};

/// Two triangles across an edge whose corners stand twice, displaced along their normals by u.
fn scene(part: Option<Part>) -> Scene {
    let mut graph = Graph::default();
    let kind = |function| NodeKind::Function(function);
    let uv = graph.add(Node::new(kind(Function::Place(PlaceInput::Uv(0)))));
    let u = graph.add(Node::new(kind(Function::SeparateXyz)).with(0, uv));
    let space = Function::Displacement { object_space: true };
    let node = Node::new(kind(space)).with(0, u).with(1, 0.0);
    graph.displacement = Some(graph.add(node));
    let mesh = Mesh {
        positions: vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ],
        normals: Some(vec![[0.0, 0.0, 1.0]; 6]),
        uvs: vec![vec![
            [0.0, 0.0],
            [1.0, 0.0],
            [0.0, 0.0],
            [0.5, 0.0],
            [1.0, 0.0],
            [0.5, 0.0],
        ]],
        attributes: vec![
            [0.0, 1.0, 2.0, 1.0, 3.0, 2.0]
                .map(|number| [number, 0.0, 1.0, 1.0])
                .to_vec(),
        ],
        triangles: vec![[0, 1, 2], [3, 4, 5]],
        material: Some(MaterialId(0)),
        part,
        ..Mesh::default()
    };
    Scene {
        meshes: vec![mesh],
        materials: vec![Material {
            graph,
            ..Material::default()
        }],
        instances: vec![Instance {
            motion: Vec::new(),
            name: "m".into(),
            mesh: MeshId(0),
            world_from_object: DAffine3::from_scale(DVec3::splat(2.0)),
            visibility: Visibility::ALL,
            holdout: false,
            info: ObjectInfo::default(),
        }],
        ..Scene::default()
    }
}

#[test]
fn a_vertex_is_moved_once_by_the_first_triangle_that_has_it() {
    let numbered = Part {
        whole: 0,
        vertices: 0,
        with_normals: false,
    };
    for part in [None, Some(numbered)] {
        let mut scene = scene(part);
        displace(&mut scene, &mut Diagnostics::default());
        let heights: Vec<f32> = scene.meshes[0].positions.iter().map(|p| p[2]).collect();
        assert_eq!(heights, [0.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
        assert!(scene.materials[0].graph.displacement.is_none());
        let normals = scene.meshes[0].normals.as_ref().unwrap();
        assert_eq!(
            normals[1], normals[3],
            "corners of one vertex are shaded alike"
        );
        assert!(normals[0][0] < -0.7, "{normals:?}");
        let generated = scene.meshes[0].generated.as_ref().unwrap();
        assert_eq!(generated[1][2], generated[0][2], "as before");
    }
}

/// A graph that moves all by 1 along the normals.
fn by_one() -> Graph {
    let mut graph = Graph::default();
    let space = Function::Displacement { object_space: true };
    let node = Node::new(NodeKind::Function(space))
        .with(0, 1.0)
        .with(1, 0.0);
    graph.displacement = Some(graph.add(node));
    graph
}

/// A cube's corners go along its diagonals, flat as it is: three faces count by their angles there, however many triangles they are.
#[test]
fn flat_meshes_are_moved_by_the_normals_of_their_vertices() {
    let corner = |i: u32| [0, 1, 2].map(|axis| (i >> axis & 1) as f32);
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let mut scene = scene(None);
    scene.materials[0].graph = by_one();
    scene.instances[0].world_from_object = DAffine3::IDENTITY;
    scene.meshes[0] = Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        material: Some(MaterialId(0)),
        ..Mesh::default()
    };
    displace(&mut scene, &mut Diagnostics::default());
    let third = 3f32.sqrt().recip();
    for (i, position) in (0..8).zip(&scene.meshes[0].positions) {
        let expected = Vec3::from(corner(i)) * (1.0 + 2.0 * third) - third;
        assert!(
            (Vec3::from(*position) - expected).length() < 1e-6,
            "{position:?}"
        );
    }
    assert!(scene.meshes[0].normals.is_none());
}

/// A face between two vertices at one place is a line until they go apart along the normals that the file says.
#[test]
fn displacement_opens_faces_without_area() {
    let mut scene = scene(Some(Part {
        whole: 0,
        vertices: 0,
        with_normals: true,
    }));
    scene.materials[0].graph = by_one();
    let numbered = |number: u32| [number as f32, 0.0, 0.0, 1.0];
    let normals = [
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
    ];
    scene.meshes[0] = Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]],
        attributes: vec![(0..3).map(numbered).collect(), normals.to_vec()],
        triangles: vec![[0, 1, 2], [0, 1, 1]],
        uvs: Vec::new(),
        ..scene.meshes[0].clone()
    };
    scene.meshes[0].normals = None;
    let mut diagnostics = Diagnostics::default();
    crate::scene::validate::clean(&mut scene, &mut diagnostics);
    displace(&mut scene, &mut diagnostics);
    let mesh = &scene.meshes[0];
    let moved = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
    assert_eq!(mesh.positions, moved, "along the normals that are told");
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.attributes.len(), 1);
    let told = diagnostics
        .iter()
        .find(|d| d.code == "degenerate-triangles");
    assert!(
        told.is_some_and(|d| d.feature.starts_with("1 triangle ")),
        "{told:?}"
    );
}
