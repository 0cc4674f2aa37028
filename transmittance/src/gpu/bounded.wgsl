// Curves as `Curve` stores them, with their bounds. Needs
//   fn avsm_word(index: u32) -> u32    the words of the map

const avsm_WORDS: u32 = 2u + avsm_NODES * (1u + 3u * avsm_CHANNELS);

fn avsm_stored_len(texel: u32) -> u32 {
    return min(avsm_word(texel * avsm_WORDS), avsm_NODES);
}

// The number of a node in a row of the curve. Row 0 has the depths; behind it are the
// values, the bounds above and the bounds below, with a row for each channel.
fn avsm_stored_number(texel: u32, row: u32, node: u32) -> f32 {
    return bitcast<f32>(avsm_word(texel * avsm_WORDS + 2u + row * avsm_NODES + node));
}

fn avsm_stored_depth(texel: u32, node: u32) -> f32 {
    return avsm_stored_number(texel, 0u, node);
}

fn avsm_stored_value(texel: u32, node: u32, channel: u32) -> f32 {
    return avsm_stored_number(texel, 1u + channel, node);
}

// A depth in the measure of the stored ones, which here is the same.
fn avsm_place(texel: u32, depth: f32) -> f32 {
    return depth;
}

// The depth of a place in that measure.
fn avsm_unplace(texel: u32, place: f32) -> f32 {
    return place;
}
