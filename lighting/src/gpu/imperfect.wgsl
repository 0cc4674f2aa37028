// Splats the points of the casters into a picture for each light: entry points.
//
// Needs the parts face.wgsl, place.wgsl and octahedron.wgsl.

struct Splats {
    // Texels per side of a picture.
    resolution: u32,
    lights: u32,
    clusters: u32,
    // The most texels from the middle of a splat to its side.
    most_texels: f32,
}

// The frame of a light, the kind of its picture, and how many texels a splat of 1 m² at a
// distance of 1 m, on an axis of the frame, measures from its middle to its side.
struct Picture {
    face: light_Face,
    scale: vec2<f32>,
    kind: u32,
    padding: u32,
}

// How many points of a cluster a light takes, and the area that each stands for, m².
struct Taken {
    count: u32,
    area: f32,
}

@group(0) @binding(0) var<uniform> splats: Splats;
@group(0) @binding(1) var<storage> pictures: array<Picture>;
// The first point of each cluster.
@group(0) @binding(2) var<storage> clusters: array<u32>;
// Light by light.
@group(0) @binding(3) var<storage> taken: array<Taken>;
@group(0) @binding(4) var<storage> points: array<vec4<f32>>;
// Depths, whose bits are in the order of their values because none is negative.
@group(0) @binding(5) var<storage, read_write> depths: array<atomic<u32>>;

// One invocation per texel.
@compute @workgroup_size(64)
fn clear(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i < splats.lights * splats.resolution * splats.resolution {
        atomicStore(&depths[i], bitcast<u32>(light_EMPTY));
    }
}

// One invocation per cluster of a light.
@compute @workgroup_size(64)
fn splat(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = gpu_index(workgroup, workgroups, local, 64u);
    if i >= splats.lights * splats.clusters {
        return;
    }
    let light = i / splats.clusters;
    let picture = pictures[light];
    let first = clusters[i % splats.clusters];
    let side = sqrt(taken[i].area);
    let n = splats.resolution;
    let last = f32(n - 1u);
    for (var k = 0u; k < taken[i].count; k += 1u) {
        let v = points[first + k].xyz - picture.face.origin;
        var texel: vec2<f32>;
        var depth: f32;
        var size = side;
        if picture.face.tan > 0.0 {
            depth = length(v);
            size = side / (depth * light_width(picture.face, v));
            texel = light_octahedral(picture.face, picture.kind, n, v);
        } else {
            depth = max(dot(v, picture.face.forward), 0.0);
            texel = light_texel_along(picture.face, n, v);
        }
        if texel.x < 0.0 {
            continue;
        }
        // The texels whose middle is in the splat, and always the texel of the point.
        let beyond = clamp(picture.scale * size, vec2(0.5), vec2(splats.most_texels)) - 0.5;
        let low = vec2<u32>(clamp(texel - beyond, vec2(0.0), vec2(last)));
        let high = vec2<u32>(clamp(texel + beyond, vec2(0.0), vec2(last)));
        for (var row = low.y; row <= high.y; row += 1u) {
            for (var column = low.x; column <= high.x; column += 1u) {
                atomicMin(&depths[(light * n + row) * n + column], bitcast<u32>(depth));
            }
        }
    }
}
