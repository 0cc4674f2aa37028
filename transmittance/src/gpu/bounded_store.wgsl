// Stores curves as bounded.wgsl reads them. Needs the part curve.wgsl and
//   fn avsm_set_word(index: u32, word: u32)    the words of the map

// Stores a curve; nodes that it does not have are zeros.
fn avsm_store(texel: u32, curve: ptr<function, avsm_Curve>) {
    let base = texel * avsm_WORDS;
    avsm_set_word(base, (*curve).len);
    avsm_set_word(base + 1u, (*curve).insertions);
    for (var i = 0u; i < avsm_NODES; i++) {
        let is_node = i < (*curve).len;
        let at = base + 2u + i;
        avsm_set_word(at, select(0u, bitcast<u32>((*curve).depth[i]), is_node));
        for (var c = 0u; c < avsm_CHANNELS; c++) {
            let place = c * avsm_CAPACITY + i;
            let value = at + (1u + c) * avsm_NODES;
            let rows = avsm_CHANNELS * avsm_NODES;
            avsm_set_word(value, select(0u, bitcast<u32>((*curve).value[place]), is_node));
            avsm_set_word(value + rows, select(0u, bitcast<u32>((*curve).above[place]), is_node));
            avsm_set_word(value + 2u * rows, select(0u, bitcast<u32>((*curve).below[place]), is_node));
        }
    }
}
