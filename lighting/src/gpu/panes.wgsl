// What covers parts of the rays of a bundle before the eye. The shader around it has `scene`
// with the number of `rays` and where in the `table` the panes begin, `panes`, NO_PANES
// without any; there the table has, for each ray, how many panes there are up to it, four to
// an entry; then the panes, the nearest to each eye first.

const NO_PANES = 0xffffffffu;

// The panes of all rays before the ray `i`.
fn panes_before(i: u32) -> u32 {
    if i == 0u {
        return 0u;
    }
    return table[scene.panes + (i - 1u) / 4u][(i - 1u) % 4u];
}

// The numbers of the first pane of a ray and of the one behind its last.
fn panes_of(i: u32) -> vec2<u32> {
    if scene.panes == NO_PANES {
        return vec2(0u);
    }
    return vec2(panes_before(i), panes_before(i + 1u));
}

// The share of what is behind a pane that it and all before it let through, and its
// distance.
fn pane_behind(pane: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(table[scene.panes + (scene.rays + 3u) / 4u + pane]);
}
