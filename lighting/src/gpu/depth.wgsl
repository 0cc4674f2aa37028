// The nearest blocker of every texel of a tile: vertex and fragment shader.
//
// The depth of a fragment is where the ray through the centre of its texel meets
// the plane of the triangle, and is not interpolated between corners: those may
// be anywhere, behind the light too. Where the ray meets a hole of a masked
// triangle there is no fragment.

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<storage> corners: array<f32>;
@group(0) @binding(2) var<storage> light_masks: array<light_Mask>;
@group(0) @binding(3) var<storage> light_mask_opacities: array<f32>;

struct Seen {
    @builtin(position) position: vec4<f32>,
    // Normal n of the triangle's plane, and n·p of the points p in it.
    @location(0) @interpolate(flat, either) plane: vec4<f32>,
    // Least and greatest depth along `forward`.
    @location(1) @interpolate(flat, either) range: vec2<f32>,
    @location(2) @interpolate(flat, either) triangle: u32,
}

// A corner in the frame of the face.
fn corner(index: u32) -> vec3<f32> {
    let world = vec3(corners[3u * index], corners[3u * index + 1u], corners[3u * index + 2u]);
    let v = world - tile.face.origin;
    return vec3(dot(v, tile.face.right), dot(v, tile.face.up), dot(v, tile.face.forward));
}

@vertex
fn project(@builtin(vertex_index) vertex: u32) -> Seen {
    let first = vertex - vertex % 3u;
    let a = corner(first);
    let b = corner(first + 1u);
    let c = corner(first + 2u);
    let normal = cross(b - a, c - a);
    let p = corner(vertex);
    var plane = vec2(0.0);
    var w = 1.0;
    var z = 0.5;
    if tile.face.tan > 0.0 {
        plane = p.xy / tile.face.tan;
        w = p.z;
        // With this z the hardware clips at the distance `near`; the fragment shader writes
        // the depth.
        z = tile.near;
    } else {
        plane = p.xy / vec2(tile.face.half_width, tile.face.half_height);
    }
    var seen: Seen;
    seen.position = vec4(plane * tile.scale + w * tile.offset, z, w);
    seen.plane = vec4(normal, dot(normal, a));
    seen.range = vec2(min(a.z, min(b.z, c.z)), max(a.z, max(b.z, c.z)));
    seen.triangle = vertex / 3u;
    return seen;
}

// Whether a masked triangle has a hole at a point of it in the frame of the face.
fn is_hole(triangle: u32, point: vec3<f32>) -> bool {
    let a = corner(3u * triangle);
    let b = corner(3u * triangle + 1u) - a;
    let c = corner(3u * triangle + 2u) - a;
    let normal = cross(b, c);
    let scale = 1.0 / dot(normal, normal);
    let u = dot(cross(point - a, c), normal) * scale;
    let v = dot(cross(b, point - a), normal) * scale;
    return light_mask_is_hole(triangle - tile.solid, vec2(u, v));
}

struct Fragment {
    @location(0) distance: f32,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn measure(seen: Seen) -> Fragment {
    let texel = (vec2<f32>(tile.first) + seen.position.xy) / f32(tile.resolution);
    let plane = vec2(2.0 * texel.x - 1.0, 1.0 - 2.0 * texel.y);
    var numerator = seen.plane.w;
    var denominator = seen.plane.z;
    var stretch = 1.0;
    if tile.face.tan > 0.0 {
        let ray = vec3(plane * tile.face.tan, 1.0);
        denominator = dot(seen.plane.xyz, ray);
        stretch = length(ray);
    } else {
        let half = vec2(tile.face.half_width, tile.face.half_height);
        numerator -= dot(seen.plane.xy, plane * half);
    }
    // For a triangle seen edge-on the quotient is noise, so it is clamped to the triangle.
    var z = seen.range.x;
    if denominator != 0.0 {
        z = clamp(numerator / denominator, seen.range.x, seen.range.y);
    }
    if seen.triangle >= tile.solid {
        var point = vec3(plane * tile.face.tan * z, z);
        if tile.face.tan == 0.0 {
            point = vec3(plane * vec2(tile.face.half_width, tile.face.half_height), z);
        }
        if is_hole(seen.triangle, point) {
            discard;
        }
    }
    let distance = max(z, 0.0) * stretch;
    return Fragment(distance, clamp(distance / tile.far, 0.0, 1.0));
}
