// From the world to the grid of a light: the shader's side of `LightSpace`.
// Needs no other part.

// Stands for an infinite parameter of a ray: f32::MAX.
const dag_FAR: f32 = 3.40282346e38;

struct dag_Space {
    // Rows of the matrix that takes the world to (X, Y, depth, W).
    x: vec4<f32>,
    y: vec4<f32>,
    depth: vec4<f32>,
    w: vec4<f32>,
    // Voxels along each axis.
    side: f32,
    // ln(far/near) of logarithmic slices; 0 for linear ones.
    stretch: f32,
    // The depth at which slices begin.
    near: f32,
    padding: f32,
}

// (X, Y, depth, W) of a point (w = 1) or a direction (w = 0).
fn dag_homogeneous(space: dag_Space, point: vec4<f32>) -> vec4<f32> {
    return vec4(
        dot(space.x, point),
        dot(space.y, point),
        dot(space.depth, point),
        dot(space.w, point),
    );
}

// The slice at a depth, as a real number whose whole part is the slice.
fn dag_slice(space: dag_Space, depth: f32) -> f32 {
    if space.stretch > 0.0 {
        return space.side * log(max(depth, 1e-30) / space.near) / space.stretch;
    }
    return space.side * depth;
}

// The depth at which a slice begins: the inverse of `dag_slice`.
fn dag_depth_of_slice(space: dag_Space, slice: f32) -> f32 {
    if space.stretch > 0.0 {
        return space.near * exp(slice / space.side * space.stretch);
    }
    return slice / space.side;
}

// The position in the grid of homogeneous coordinates, in voxels: the whole
// part is the voxel. Only in front of the light, W > 0.
fn dag_position(space: dag_Space, h: vec4<f32>) -> vec3<f32> {
    return vec3(space.side * h.xy / h.w, dag_slice(space, h.z));
}

// The voxel of a position, cut off far outside of the grid.
fn dag_voxel_at(position: vec3<f32>) -> vec3<i32> {
    return vec3<i32>(clamp(floor(position), vec3(-4194304.0), vec3(4194304.0)));
}

// The direction that a surface normal has in the grid, at a point whose homogeneous
// coordinates are `h`: a vector of length 1, or zero where there is none. A normal transforms
// by the inverse transpose of the derivative of the position, whose rows are, up to a factor,
// the cross products of the derivative's rows.
fn dag_normal(space: dag_Space, h: vec4<f32>, normal: vec3<f32>) -> vec3<f32> {
    var x = space.x.xyz;
    var y = space.y.xyz;
    var z = space.depth.xyz;
    if space.stretch > 0.0 {
        x -= space.w.xyz * (h.x / h.w);
        y -= space.w.xyz * (h.y / h.w);
        z = space.w.xyz / space.stretch;
    }
    let across = cross(x, y);
    let n = vec3(dot(cross(y, z), normal), dot(cross(z, x), normal), dot(across, normal));
    let turned = select(n, -n, dot(across, z) < 0.0);
    let size = max(max(abs(n.x), abs(n.y)), abs(n.z));
    if !(size > 0.0) || !(h.w > 0.0) {
        return vec3(0.0);
    }
    return normalize(turned / size);
}

// The voxel at which to ask a filter of `width` for the light on a surface at
// a position: half a width along its normal in the grid, in whole voxels, so
// that the window clears the surface itself.
fn dag_bias(position: vec3<f32>, normal: vec3<f32>, width: u32) -> vec3<i32> {
    return dag_bias_beyond(position, normal, width, 0.0);
}

// The same, `beyond` voxels farther along the normal.
fn dag_bias_beyond(position: vec3<f32>, normal: vec3<f32>, width: u32, beyond: f32) -> vec3<i32> {
    let offset = normal * (0.5 * f32(width) + beyond);
    // Rounds half away from zero, which WGSL's round does not.
    let step = sign(offset) * floor(abs(offset) + vec3(0.5));
    return dag_voxel_at(position) + vec3<i32>(step);
}
