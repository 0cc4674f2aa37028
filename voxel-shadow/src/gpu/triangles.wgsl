// Voxelisation from triangles: entry point, one invocation per light ray. A
// workgroup reads the triangles together, in batches of as many as it has
// invocations, and each invocation tests its own ray with all of a batch.
//
// Needs the slot of holes,
//   fn vsv_is_hole(triangle: u32, at: vec2<f32>) -> bool

struct Parameters {
    lattice: epi_Lattice,
    // The triangles of this pass; the first pass begins with the first of all.
    first: u32,
    end: u32,
}

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage> planes: array<vec2<f32>>;
@group(0) @binding(2) var<storage> light_angles: array<vec2<f32>>;
// Nine coordinates for each triangle.
@group(0) @binding(3) var<storage> corners: array<f32>;
@group(0) @binding(4) var<storage, read_write> indices: array<u32>;

var<workgroup> batch: array<array<vec3<f32>, 3>, 64>;

fn corner(index: u32) -> vec3<f32> {
    return vec3(corners[3u * index], corners[3u * index + 1u], corners[3u * index + 2u]);
}

// The distance at which a ray meets a triangle, or epi_INFINITE, and the barycentric
// coordinates of its second and third corner there. The volumes that the ray spans with the
// three edges have equal signs inside. Two triangles compute the same number but for its sign
// for their common edge, so that no ray passes between them.
fn hit(ray: epi_LightRay, triangle: array<vec3<f32>, 3>, directional: bool) -> vec3<f32> {
    let a = triangle[0] - ray.origin;
    let b = triangle[1] - ray.origin;
    let c = triangle[2] - ray.origin;
    let v = vec3(
        dot(ray.direction, cross(b, c)),
        dot(ray.direction, cross(c, a)),
        dot(ray.direction, cross(a, b)),
    );
    let inside = all(v >= vec3(0.0)) || all(v <= vec3(0.0));
    let sum = v.x + v.y + v.z;
    if !inside || sum == 0.0 {
        return vec3(epi_INFINITE, 0.0, 0.0);
    }
    let along = vec3(dot(a, ray.direction), dot(b, ray.direction), dot(c, ray.direction));
    let distance = dot(v, along) / sum;
    return vec3(select(epi_INFINITE, distance, directional || distance >= 0.0), v.yz / sum);
}

@compute @workgroup_size(64)
fn rectify_triangles(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let l = parameters.lattice;
    let rays = l.theta * l.bits;
    let i = gpu_index(workgroup, workgroups, local, 64u);
    // Invocations without a ray of their own still read triangles and meet at the barriers.
    let at = min(i, rays - 1u);
    let phi = light_angles[at % l.bits];
    let ray = epi_light_ray(l, planes[at / l.bits], phi);
    var nearest = l.alpha;
    if parameters.first > 0u {
        nearest = indices[at];
    }
    for (var first = parameters.first; first < parameters.end; first += 64u) {
        let count = min(64u, parameters.end - first);
        if local < count {
            let index = 3u * (first + local);
            batch[local] = array(corner(index), corner(index + 1u), corner(index + 2u));
        }
        workgroupBarrier();
        for (var k = 0u; k < count; k += 1u) {
            let met = hit(ray, batch[k], l.directional != 0u);
            let index = epi_blocked_from(l, phi, met.x);
            // A hole is looked up only where it would change the result.
            if index < nearest && !vsv_is_hole(first + k, met.yz) {
                nearest = index;
            }
        }
        workgroupBarrier();
    }
    if i < rays {
        indices[i] = nearest;
    }
}
