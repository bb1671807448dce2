//! The labels of a scene: for each pixel or point the number of its cylinder from 1 on, or 0.

/// Labels that are looked through at a time.
const BLOCK: usize = 64;

/// The pixels or points of one region, counted from 0.
pub(super) fn indices_of(labels: &[u16], index: usize) -> impl Iterator<Item = usize> + Clone + '_ {
    // Labels count from 1 in 16 bits.
    let own = u16::try_from(index + 1).ok();
    // Most blocks have others: looked through many at a time.
    let has_own = move |labels: &[u16]| labels.iter().fold(false, |any, label| any | (Some(*label) == own));
    let blocks = labels.chunks(BLOCK).enumerate().filter(move |(_, labels)| has_own(labels));
    blocks.flat_map(move |(block, labels)| {
        let of_block = labels.iter().enumerate().filter(move |(_, label)| Some(**label) == own);
        of_block.map(move |(k, _)| block * BLOCK + k)
    })
}

/// The mask of one region, 1 inside.
pub(super) fn mask_of(labels: &[u16], index: usize) -> Vec<u8> {
    // Labels count from 1 in 16 bits.
    let own = (index + 1) as u16;
    labels.iter().map(|&label| u8::from(label == own)).collect()
}

/// Gives labels the numbers in a new order; those that are not in it become 0.
pub(super) fn renumber(labels: &mut [u16], order: impl Iterator<Item = u16>) {
    let mut new = vec![0; usize::from(u16::MAX) + 1];
    for (number, label) in (1..).zip(order) {
        new[usize::from(label)] = number;
    }
    // Most blocks have none.
    let has_any = |labels: &&mut [u16]| labels.iter().fold(0, |any, label| any | label) != 0;
    for labels in labels.chunks_mut(BLOCK).filter(has_any) {
        labels.iter_mut().for_each(|label| *label = new[usize::from(*label)]);
    }
}
