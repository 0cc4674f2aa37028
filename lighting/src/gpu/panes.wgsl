// Panes in front of the eye, which cover parts of the rays of a bundle.
//
// Needs, from the entry point, `table`, and `scene` with the number of `rays` and the entry
// of the table at which the panes begin, `panes`; NO_PANES if there are none. From there the
// table has the number of panes of all rays up to and including each ray, four numbers to an
// entry; then the panes, an entry each, those of a ray from near to far.

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

// The share of the light from behind a pane that it and those in front of it let through, per
// colour, and its distance, m.
fn pane_behind(pane: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(table[scene.panes + (scene.rays + 3u) / 4u + pane]);
}
