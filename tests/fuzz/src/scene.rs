//! Scene files of every format, through to a tiny picture.

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::methods::Entry;
use lighting::scene::load::{
    LoadError, LoadOptions, Loaded, UpAxis, gltf_from_slice, hair_from_slice, nvdb_from_slice,
    obj_from_slice, ply_from_slice, vdb_from_slice, vol_colours_from_slice, vol_from_slice,
};
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{Emitter, Geometry, Medium, Mesh, Scene, Translucent};

use super::frame::{METHODS, Tiny};

/// Between a file and another one that it refers to.
const OTHER: &[u8] = b"\n--file--\n";

/// Scenes with more than this load, and are not rendered.
const MOST: usize = 4096;

/// The two bytes in front of a file: its format, and how it is read.
fn load(format: u8, how: u8, file: &[u8]) -> Result<Loaded, LoadError> {
    let is_gltf = format.is_multiple_of(7);
    let options = LoadOptions {
        lenient: how & 1 == 1,
        assets: None,
        unit: if how & 2 == 2 && !is_gltf { 0.01 } else { 1.0 },
        up: match how >> 2 & 3 {
            1 if !is_gltf => UpAxis::X,
            2 if !is_gltf => UpAxis::Z,
            _ => UpAxis::Y,
        },
    };
    let end = file.windows(OTHER.len()).position(|window| window == OTHER);
    let (file, other) = match end {
        Some(end) => (&file[..end], &file[end + OTHER.len()..]),
        None => (file, &[][..]),
    };
    let mut open = |_: &str| Ok(other.to_vec());
    match format % 7 {
        0 => gltf_from_slice(file, &options, &mut open),
        1 => obj_from_slice(file, &options, &mut open),
        2 => ply_from_slice(file, &options),
        3 => hair_from_slice(file, &options),
        4 => {
            drop(vol_colours_from_slice(file, &options));
            vol_from_slice(file, &options)
        }
        5 => nvdb_from_slice(file, &options),
        _ => vdb_from_slice(file, &options),
    }
}

/// The scene with a triangle at least, on which what is of smoke or hair alone stands.
fn on_the_ground(scene: Scene) -> Scene {
    if !scene.meshes.is_empty() {
        return scene;
    }
    let ground = Scene::from(Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    Scene {
        meshes: ground.meshes,
        instances: ground.instances,
        ..scene
    }
}

/// How much there is to go through of smoke and hair.
fn parts(scene: &Scene) -> usize {
    let parts = |translucent: &Translucent| match translucent {
        Translucent::Grid(grid) => grid.density().len() / 64,
        Translucent::Strands(strands) => strands.points().len(),
        _ => 0,
    };
    scene.translucent.iter().map(parts).sum()
}

/// Whether nothing in a scene is so bright, so dense or so near to its limits that light
/// itself leaves the range of f32.
fn is_tame(emitters: &[Emitter], medium: &Medium) -> bool {
    let is_tame = |light: &Emitter| light.intensity().max_element() < 1e9;
    emitters.iter().all(is_tame) && medium.sigma_s().max_element() < 1e9
}

fn render(scene: Scene, method: &Entry) {
    let mut scene = on_the_ground(scene);
    let Ok(geometry) = Geometry::new(&scene) else {
        return;
    };
    if geometry.triangles().len() > MOST || parts(&scene) > MOST {
        return;
    }
    // What is missing cannot always be placed: of a scene of 1e9 m, for one.
    if scene.complete(geometry.bounds()).is_err() || scene.fill_with_fog(geometry.bounds()).is_err()
    {
        return;
    }
    let Some(camera) = scene.camera else { return };
    let tracer = Tracer::new(&geometry);
    let view = View::new(&Cpu::single_threaded(), &camera, &tracer, 4, 4).expect("a legal size");
    let emitters: Result<Vec<Vec<Emitter>>, _> =
        (scene.lights.iter().take(4).map(|light| light.emitters(2))).collect();
    let Ok(emitters) = emitters else { return };
    let emitters = emitters.concat();
    let medium = scene.medium.unwrap_or(Medium::VACUUM);
    let tiny = Tiny {
        geometry: &geometry,
        camera: &camera,
        view: &view,
        medium: &medium,
        height_fog: scene.height_fog.as_ref(),
        translucent: &scene.translucent,
    };
    if let Ok(image) = tiny.image(&emitters, method, method.about().usual) {
        let is_sound =
            |value: &f32| *value >= 0.0 && (value.is_finite() || !is_tame(&emitters, &medium));
        assert!(image.iter().flatten().all(is_sound), "{image:?}");
    }
}

/// A file of any format gives an error or a scene, and a scene an error or a picture of
/// numbers that are not negative, by a method that the third byte chooses.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let [format, how, method, file @ ..] = data else {
        return;
    };
    let Ok(Loaded { scene, .. }) = load(*format, *how, file) else {
        return;
    };
    let methods = [
        "exact x quadrature",
        "march x midpoint",
        "translucent x midpoint",
        "voxel-runs x gauss-8",
    ];
    let name = methods[usize::from(*method) % methods.len()];
    let heterogeneous = scene.height_fog.is_some() || !scene.translucent.is_empty();
    let entry = match METHODS.for_heterogeneous_media() {
        Some(entry) if heterogeneous && method & 128 == 0 => entry.clone(),
        _ => METHODS.find(name).expect("a standard method"),
    };
    render(scene, &entry);
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A binary glTF file.
fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut chunks = Vec::new();
    for (kind, bytes, fill) in [(b"JSON", json.as_bytes(), b' '), (b"BIN\0", binary, 0)] {
        let padded = bytes.len().next_multiple_of(4);
        chunks.extend((padded as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(bytes);
        chunks.resize(chunks.len() + padded - bytes.len(), fill);
    }
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((chunks.len() as u32 + 12).to_le_bytes());
    [file, chunks].concat()
}

/// A tetrahedron with normals, colours and texture coordinates, all extras and lights of
/// every kind.
const SCENE: &str = r#"{"asset":{"version":"2.0"},"scene":0,
"extensionsUsed":["KHR_lights_punctual","EXT_lights_area"],
"extensions":{"KHR_lights_punctual":{"lights":[
{"type":"point","color":[1,0.5,0.2],"intensity":40,"range":9,"extras":{"falloff":"hard"}},
{"type":"spot","intensity":100,"spot":{"innerConeAngle":0.1,"outerConeAngle":0.6}},
{"type":"directional","intensity":3,"extras":{"angularDiameter":0.0093}}]}},
"scenes":[{"nodes":[0,1,2,3,4],"extras":{"medium":{"sigma_s":[0.02,0.03,0.05],"sigma_a":0.001,
"phase":"henyey-greenstein","g":0.3,"box":[[-5,-1,-5],[5,4,5]]},
"heightFog":{"sigma_s":0.02,"scaleHeight":30,"altitude":1}}}],
"nodes":[{"mesh":0,"rotation":[0,0.7071,0,0.7071],"scale":[2,2,-2]},
{"camera":0,"translation":[0.2,0.4,4]},
{"translation":[0,2,0],"extensions":{"KHR_lights_punctual":{"light":0}}},
{"translation":[1,2,1],"rotation":[-0.7071,0,0,0.7071],
"extensions":{"KHR_lights_punctual":{"light":1}},"extras":{"dynamic":true}},
{"extensions":{"KHR_lights_punctual":{"light":2}},"children":[5]},
{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,-2,0,0,1],"extras":{"castsShadow":false}}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.9,"znear":0.1}}],
"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.8,0.2,0.1,0.5]},"alphaMode":"BLEND",
"emissiveFactor":[0,0.5,1],"doubleSided":true,
"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5}}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2},"indices":1,"material":0,
"targets":[{"POSITION":0}]}],"weights":[0.25]}],
"buffers":[{"byteLength":132}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24},
{"buffer":0,"byteOffset":72,"byteLength":48},{"buffer":0,"byteOffset":120,"byteLength":12}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4,
"min":[0,0,0],"max":[1,1,1],
"sparse":{"count":1,"indices":{"bufferView":1,"byteOffset":2,"componentType":5123},
"values":{"bufferView":3}}},
{"bufferView":1,"componentType":5123,"type":"SCALAR","count":12},
{"bufferView":2,"componentType":5126,"type":"VEC3","count":4}]}"#;

/// A triangle in a compressed stream of its own.
const DRACO: &str = r#"{"asset":{"version":"2.0"},
"extensionsRequired":["KHR_draco_mesh_compression"],"extensionsUsed":["KHR_draco_mesh_compression"],
"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"buffers":[{"byteLength":LENGTH}],
"bufferViews":[{"buffer":0,"byteLength":LENGTH}],
"accessors":[{"componentType":5126,"type":"VEC3","count":4},
{"componentType":5123,"type":"SCALAR","count":12}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"extensions":{
"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":NUMBER}}}}]}]}"#;

const OBJ: &str = "mtllib scene.mtl\no leaf\nv 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nvt 0 0\nvt 1 1\n\
usemtl glass\nf 1/1 2/2 3 4\ng other\nusemtl lamp\nf -4 -3 -1\n";

const MTL: &str = "newmtl glass\nKd 0.2 0.5 0.1\nd 0.4\nmap_Kd scene.png\n\
newmtl lamp\nKe 4 3 2\nTr 0.5\nKd 1 1 1\n";

const PLY: &str = "ply\nformat ascii 1.0\ncomment a quad\nelement vertex 4\nproperty float x\n\
property float y\nproperty double z\nelement face 1\nproperty list uchar int vertex_indices\n\
end_header\n0 0 0\n1 0 0\n1 1 0.5\n0 1 0\n4 0 1 2 3\n";

const STRIPS: &str = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n\
property float y\nproperty float z\nelement tristrips 1\n\
property list int int vertex_indices\nend_header\n";

/// The tetrahedron as Draco's own encoder compresses it.
const TETRAHEDRON: [(&[u8], &str); 3] = [
    (
        include_bytes!("../../../lighting/scene/src/load/testdata/standard.drc"),
        "2",
    ),
    (
        include_bytes!("../../../lighting/scene/src/load/testdata/valence.drc"),
        "2",
    ),
    (
        include_bytes!("../../../lighting/scene/src/load/testdata/sequential.drc"),
        "0",
    ),
];

const NVDB: [&[u8]; 2] = [
    include_bytes!("../../../lighting/scene/src/load/testdata/density.nvdb"),
    include_bytes!("../../../lighting/scene/src/load/testdata/two.nvdb"),
];

/// Files of OpenVDB as ZLIB data: packed by Blosc, by ZIP, as half floats, with inactive
/// values, and of an emission alone.
const VDB: [&[u8]; 5] = [
    include_bytes!("../../../lighting/scene/src/load/testdata/blosc.vdb.zz"),
    include_bytes!("../../../lighting/scene/src/load/testdata/zip.vdb.zz"),
    include_bytes!("../../../lighting/scene/src/load/testdata/half.vdb.zz"),
    include_bytes!("../../../lighting/scene/src/load/testdata/inactive.vdb.zz"),
    include_bytes!("../../../lighting/scene/src/load/testdata/flames.vdb.zz"),
];

/// Small files of every format, compressed or not.
pub fn seeds() -> Vec<Vec<u8>> {
    let mut tetrahedron = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    for index in [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3_u16] {
        tetrahedron.extend(index.to_le_bytes());
    }
    tetrahedron.extend(floats(&[0.5; 12]));
    tetrahedron.extend(floats(&[0.9, 0.1, 0.2]));
    let obj = [OBJ.as_bytes(), OTHER, MTL.as_bytes()].concat();
    let mut strips = STRIPS.as_bytes().to_vec();
    strips.extend(floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
    strips.extend([4, 0, 1, 2, -1_i32].iter().flat_map(|x| x.to_le_bytes()));
    // Two strands of three points, with a thickness each.
    let mut hair = b"HAIR".to_vec();
    hair.extend([2, 6, 7, 2_u32].iter().flat_map(|x| x.to_le_bytes()));
    hair.extend(floats(&[0.1, 0.5, 0.8, 0.6, 0.4]));
    hair.extend([b'x'; 88]);
    hair.extend([2_u16, 2].iter().flat_map(|x| x.to_le_bytes()));
    hair.extend((0..18).flat_map(|i: u8| (0.1 * f32::from(i)).to_le_bytes()));
    hair.extend(floats(&[0.05; 6]));
    let vol = |channels: u32| {
        let mut vol = b"VOL\x03".to_vec();
        vol.extend([1, 3, 2, 2, channels].iter().flat_map(|x| x.to_le_bytes()));
        vol.extend(floats(&[-1.0, 0.0, -1.0, 1.0, 2.0, 1.0]));
        vol.extend((0..12 * channels as u8).flat_map(|i| (0.1 * f32::from(i)).to_le_bytes()));
        vol
    };
    let mut files = vec![
        (0, glb(SCENE, &tetrahedron)),
        (0, [SCENE.as_bytes(), OTHER, &tetrahedron].concat()),
        (1, obj),
        (2, PLY.into()),
        (2, strips),
        (3, hair),
        (4, vol(1)),
        (4, vol(3)),
    ];
    files.extend(TETRAHEDRON.map(|(stream, position)| {
        let json = DRACO.replace("LENGTH", &stream.len().to_string());
        (0, glb(&json.replace("NUMBER", position), stream))
    }));
    files.extend(NVDB.map(|file| (5, file.to_vec())));
    files.extend(VDB.map(|packed| {
        let file = miniz_oxide::inflate::decompress_to_vec_zlib(packed);
        (6, file.expect("ZLIB data"))
    }));
    let mut seeds = Vec::new();
    for (format, file) in files {
        for method in [0, 1, 2 + 128, 3 + 128] {
            seeds.push([&[format, method & 1, method], file.as_slice()].concat());
        }
    }
    seeds
}
