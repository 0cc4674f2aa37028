//! Small scene files of every format, with all that they may have.

use super::super::bytes::crc32;
use super::OTHER;

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A binary glTF file.
fn glb(json: impl AsRef<[u8]>, binary: &[u8]) -> Vec<u8> {
    let mut chunks = Vec::new();
    for (kind, bytes, fill) in [(b"JSON", json.as_ref(), b' '), (b"BIN\0", binary, 0)] {
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

/// A binary glTF file with the lengths that its parts have, or else the file as it is.
pub(super) fn with_lengths(file: &[u8]) -> Vec<u8> {
    let parts = || {
        let parts = file.strip_prefix(b"glTF")?.get(16..)?;
        let is_kind = |window: &[u8]| window == b"BIN\0";
        let kind = parts.windows(4).skip(4).position(is_kind)? + 4;
        Some(glb(&parts[..kind - 4], &parts[kind + 4..]))
    };
    parts().unwrap_or_else(|| file.to_vec())
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

const OBJ: &str = "mtllib 1.mtl\no leaf\nv 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nvt 0 0\nvt 1 1\n\
usemtl glass\nf 1/1 2/2 3 4\ng other\nusemtl lamp\nf -4 -3 -1\n";

const MTL: &str = "newmtl glass\nKd 0.2 0.5 0.1\nd 0.4\nmap_Kd 2.png\n\
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
        include_bytes!("../../../../lighting/scene/src/load/testdata/standard.drc"),
        "2",
    ),
    (
        include_bytes!("../../../../lighting/scene/src/load/testdata/valence.drc"),
        "2",
    ),
    (
        include_bytes!("../../../../lighting/scene/src/load/testdata/sequential.drc"),
        "0",
    ),
];

const NVDB: [&[u8]; 2] = [
    include_bytes!("../../../../lighting/scene/src/load/testdata/density.nvdb"),
    include_bytes!("../../../../lighting/scene/src/load/testdata/two.nvdb"),
];

/// A square with a mask of holes and a square that shines, both with a texture that is
/// placed, the first of them many times; a spotlight with a cookie and an area light, an
/// orthographic camera, a node that is hidden.
const TEXTURED: &str = r#"{"asset":{"version":"2.0"},
"extensionsUsed":["KHR_lights_punctual","EXT_lights_area","EXT_mesh_gpu_instancing",
"KHR_texture_transform","KHR_materials_transmission","KHR_materials_emissive_strength",
"KHR_node_visibility"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","intensity":50,
"spot":{"outerConeAngle":0.7},"extras":{"cookie":{"image":0,"rotation":0.5}}}]},
"EXT_lights_area":{"lights":[{"type":"rect","intensity":20,"size":0.5,"rect":{"aspect":2}},
{"type":"disk","color":[1,0.5,0],"size":0.1}]}},
"scenes":[{"nodes":[0,1,2,3,4,5]}],
"nodes":[{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":3}}}},
{"translation":[0,0,3],"extensions":{"KHR_lights_punctual":{"light":0}}},
{"mesh":1,"translation":[0,2,0],"rotation":[0.7071,0,0,0.7071]},
{"translation":[0,3,0],"extensions":{"EXT_lights_area":{"light":0}},"children":[6]},
{"camera":0,"translation":[0,0.5,4]},
{"mesh":0,"extensions":{"KHR_node_visibility":{"visible":false}}},
{"translation":[0.1,0,0],"extensions":{"EXT_lights_area":{"light":1}}}],
"cameras":[{"type":"orthographic","orthographic":{"xmag":2,"ymag":1,"zfar":9,"znear":0.1}}],
"images":[{"uri":"1.png"}],"samplers":[{"magFilter":9728,"wrapS":33071,"wrapT":33648}],
"textures":[{"source":0,"sampler":0}],
"materials":[{"alphaMode":"MASK","alphaCutoff":0.4,"pbrMetallicRoughness":{"baseColorTexture":
{"index":0,"extensions":{"KHR_texture_transform":{"offset":[0.1,0.2],"rotation":0.3,"scale":[2,3]}}}},
"extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5,
"transmissionTexture":{"index":0}}}},
{"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0},
"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":5}}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]},
{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":1}]}],
"buffers":[{"byteLength":120}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},
{"buffer":0,"byteOffset":80,"byteLength":12},{"buffer":0,"byteOffset":96,"byteLength":24}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4},
{"bufferView":1,"componentType":5126,"type":"VEC2","count":4},
{"bufferView":2,"componentType":5123,"type":"SCALAR","count":6},
{"bufferView":3,"componentType":5126,"type":"VEC3","count":2}]}"#;

/// A triangle that two joints bend.
const POSED: &str = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],
"nodes":[{"mesh":0,"skin":0},{"children":[2],"translation":[0,1,0]},
{"rotation":[0,0,0.3827,0.9239],"scale":[1,2,1]}],
"skins":[{"joints":[1,2],"inverseBindMatrices":3}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}]}],
"buffers":[{"byteLength":224}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12},
{"buffer":0,"byteOffset":48,"byteLength":48},{"buffer":0,"byteOffset":96,"byteLength":128}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},
{"bufferView":1,"componentType":5121,"type":"VEC4","count":3},
{"bufferView":2,"componentType":5126,"type":"VEC4","count":3},
{"bufferView":3,"componentType":5126,"type":"MAT4","count":2}]}"#;

/// The tetrahedron in streams of meshoptimizer.
const COMPRESSED: &str = r#"{"asset":{"version":"2.0"},
"extensionsUsed":["EXT_meshopt_compression"],"extensionsRequired":["EXT_meshopt_compression"],
"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"buffers":[{"byteLength":LENGTH},{"byteLength":72,"extensions":{"EXT_meshopt_compression":{"fallback":true}}}],
"bufferViews":[{"buffer":1,"byteLength":48,"byteStride":12,"extensions":{"EXT_meshopt_compression":{
"buffer":0,"byteLength":VERTICES,"byteStride":12,"count":4,"mode":"ATTRIBUTES"}}},
{"buffer":1,"byteOffset":48,"byteLength":24,"extensions":{"EXT_meshopt_compression":{
"buffer":0,"byteOffset":VERTICES,"byteLength":INDICES,"byteStride":2,"count":12,"mode":"INDICES"}}}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":4},
{"bufferView":1,"componentType":5123,"type":"SCALAR","count":12}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}]}"#;

/// Smoke from one file and its colours from two more, and a triangle.
const SMOKE: &str = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"uri":"5.bin","byteLength":36}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}],
"nodes":[{"mesh":0,"scale":[2,1,2],"rotation":[0,0.3827,0,0.9239],"extras":{"smoke":{"uri":"1.vol",
"albedo":{"uri":"2.vol"},"emission":{"uri":"3.vol","scale":[5,2,1]},
"phase":"double-henyey-greenstein","g":[0.8,-0.2],"weight":0.7}}},
{"translation":[3,0,0],"extras":{"smoke":{"uri":"4.vdb","albedo":0.6}}}]}"#;

/// Files of OpenVDB as ZLIB data: packed by Blosc, by ZIP, as half floats, with inactive
/// values, and of an emission alone.
const VDB: [&[u8]; 5] = [
    include_bytes!("../../../../lighting/scene/src/load/testdata/blosc.vdb.zz"),
    include_bytes!("../../../../lighting/scene/src/load/testdata/zip.vdb.zz"),
    include_bytes!("../../../../lighting/scene/src/load/testdata/half.vdb.zz"),
    include_bytes!("../../../../lighting/scene/src/load/testdata/inactive.vdb.zz"),
    include_bytes!("../../../../lighting/scene/src/load/testdata/flames.vdb.zz"),
];

/// An image of 2 × 2 pixels with an opacity each.
fn png() -> Vec<u8> {
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], bytes: &[u8]| {
        let content = [kind, bytes].concat();
        file.extend((bytes.len() as u32).to_be_bytes());
        file.extend(&content);
        file.extend(crc32(&content).to_be_bytes());
    };
    chunk(b"IHDR", &[0, 0, 0, 2, 0, 0, 0, 2, 8, 6, 0, 0, 0]);
    let rows = [
        0, 255, 0, 0, 255, 0, 255, 0, 128, 0, 9, 200, 255, 0, 30, 60, 90, 255,
    ];
    chunk(
        b"IDAT",
        &miniz_oxide::deflate::compress_to_vec_zlib(&rows, 6),
    );
    chunk(b"IEND", &[]);
    file
}

/// The buffer of [`TEXTURED`].
fn square() -> Vec<u8> {
    let mut bytes = floats(&[
        -1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0,
    ]);
    bytes.extend(floats(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]));
    bytes.extend(
        [0, 1, 2, 0, 2, 3, 0, 0_u16]
            .iter()
            .flat_map(|i| i.to_le_bytes()),
    );
    bytes.extend(floats(&[0.0, 0.0, -1.0, 0.5, 0.2, -2.0]));
    bytes
}

/// The buffer of [`POSED`].
fn bent() -> Vec<u8> {
    let mut bytes = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.extend([0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    bytes.extend(floats(&[
        1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0,
    ]));
    // The identity, twice.
    bytes.extend((0..32_u8).flat_map(|i| f32::from(u8::from(i % 16 % 5 == 0)).to_le_bytes()));
    bytes
}

/// [`COMPRESSED`] with its streams: bytes of vertices as differences from the vertex before,
/// all of them 8 bits, and indices as differences from the index before.
fn compressed(vertices: &[u8], indices: &[u16]) -> Vec<u8> {
    const STRIDE: usize = 12;
    let mut stream = vec![0xa0];
    for channel in 0..STRIDE {
        let mut before = vertices[channel];
        // Groups of 16 bytes, of which this is the only one.
        stream.push(3);
        let mut group = [0; 16];
        for (delta, vertex) in group.iter_mut().zip(vertices.chunks_exact(STRIDE)) {
            let change = vertex[channel].wrapping_sub(before) as i8;
            *delta = ((change << 1) ^ (change >> 7)) as u8;
            before = vertex[channel];
        }
        stream.extend(group);
    }
    stream.extend([0; 32 - STRIDE]);
    stream.extend(&vertices[..STRIDE]);
    let length = stream.len();
    stream.push(0xd1);
    let mut before = 0;
    for &index in indices {
        let change = i32::from(index) - before;
        stream.push((((change << 1) ^ (change >> 31)) << 1) as u8);
        before = i32::from(index);
    }
    stream.extend([0; 4]);
    let json = COMPRESSED
        .replace("LENGTH", &stream.len().to_string())
        .replace("VERTICES", &length.to_string())
        .replace("INDICES,", &format!("{},", stream.len() - length));
    glb(&json, &stream)
}

/// A file of PLY whose numbers begin with their largest byte.
fn quad_in_big_endian() -> Vec<u8> {
    let mut file = b"ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty float x\n\
        property float y\nproperty float z\nelement face 1\n\
        property list uchar ushort vertex_index\nend_header\n"
        .to_vec();
    let corners = [
        0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 2.0, 0.0_f32,
    ];
    file.extend(corners.iter().flat_map(|x| x.to_be_bytes()));
    file.push(4);
    file.extend([0, 1, 2, 3_u16].iter().flat_map(|i| i.to_be_bytes()));
    file
}

/// Each file with the number of its format.
pub(super) fn all() -> Vec<(u8, Vec<u8>)> {
    let indices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3_u16];
    let mut tetrahedron = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let compressed = compressed(&tetrahedron, &indices);
    for index in indices {
        tetrahedron.extend(index.to_le_bytes());
    }
    tetrahedron.extend(floats(&[0.5; 12]));
    tetrahedron.extend(floats(&[0.9, 0.1, 0.2]));
    let png = png();
    let obj = [OBJ.as_bytes(), OTHER, MTL.as_bytes(), OTHER, &png].concat();
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
    // Albedos of colours are no larger than 1.
    let vol = |channels: u32| {
        let mut vol = b"VOL\x03".to_vec();
        vol.extend([1, 3, 2, 2, channels].iter().flat_map(|x| x.to_le_bytes()));
        vol.extend(floats(&[-1.0, 0.0, -1.0, 1.0, 2.0, 1.0]));
        vol.extend((0..12 * channels as u8).flat_map(|i| (0.02 * f32::from(i)).to_le_bytes()));
        vol
    };
    let vdb = VDB.map(|packed| {
        let file = miniz_oxide::inflate::decompress_to_vec_zlib(packed);
        file.expect("ZLIB data")
    });
    let smoke = [
        SMOKE.as_bytes(),
        &vol(1),
        &vol(3),
        &vol(3),
        &vdb[0],
        &tetrahedron[..36],
    ]
    .join(OTHER);
    let with_uri = SCENE.replace(
        r#"{"byteLength":132}"#,
        r#"{"uri":"1.bin","byteLength":132}"#,
    );
    let mut files = vec![
        (0, [&glb(TEXTURED, &square()), OTHER, &png].concat()),
        (0, glb(POSED, &bent())),
        (0, compressed),
        (0, smoke),
        (2, quad_in_big_endian()),
        (0, glb(SCENE, &tetrahedron)),
        (0, [with_uri.as_bytes(), OTHER, &tetrahedron].concat()),
        (1, obj),
        (2, PLY.into()),
        (2, strips),
        (3, hair),
        (4, vol(1)),
        (4, vol(3)),
    ];
    files.extend(TETRAHEDRON.map(|(stream, position)| {
        let json = DRACO.replace("LENGTH", &stream.len().to_string());
        (0, glb(json.replace("NUMBER", position), stream))
    }));
    files.extend(NVDB.map(|file| (5, file.to_vec())));
    files.extend(vdb.map(|file| (6, file)));
    files
}
