// The renderer's own pass over its smoke, seen from the light: each fragment of a puff
// appends what is in the way of its texel's light.

struct Light {
    // The light shines along −y; the map covers `low` to `low + size`, and depths are
    // counted from `top`.
    low: vec2<f32>,
    size: f32,
    top: f32,
    // Texels per side of the map, and how many fragments the buffers have room for.
    texels: u32,
    room: u32,
    // Extinction of the smoke, 1/m.
    sigma_t: f32,
    padding: f32,
}

@group(0) @binding(0) var<uniform> light: Light;
// Centres and radii.
@group(0) @binding(1) var<storage> puffs: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> count: atomic<u32>;
// For each fragment its texel; and its entry, exit and optical depth.
@group(0) @binding(3) var<storage, read_write> texels: array<u32>;
@group(0) @binding(4) var<storage, read_write> numbers: array<f32>;

struct Fragment {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) puff: u32,
}

@vertex
fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) puff: u32) -> Fragment {
    let corner = vec2(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
    let at = (puffs[puff].xz + puffs[puff].w * corner - light.low) / light.size;
    return Fragment(vec4(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0), puff);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4<f32> {
    let puff = puffs[in.puff];
    let aside = light.low + in.position.xy / f32(light.texels) * light.size - puff.xz;
    let half = sqrt(max(puff.w * puff.w - dot(aside, aside), 0.0));
    if half > 0.0 {
        let i = atomicAdd(&count, 1u);
        if i < light.room {
            let texel = vec2<u32>(in.position.xy);
            let depth = light.top - puff.y;
            texels[i] = texel.y * light.texels + texel.x;
            numbers[3u * i] = depth - half;
            numbers[3u * i + 1u] = depth + half;
            numbers[3u * i + 2u] = light.sigma_t * 2.0 * half;
        }
    }
    return vec4(0.0);
}
