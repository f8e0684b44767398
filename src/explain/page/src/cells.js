// Cells as solids of their own, which can be moved apart.

/** Cells with corners of their own: triangles, edges, and of each corner its cell and where the middle of that is. */
export function solidOf(cells, shown) {
  const [positions, owner, triangles, edges, middles] = [[], [], [], [], []];
  for (const cell of shown) {
    const corners = [...new Set(cells.facets[cell].flat())];
    const middle = [0, 1, 2].map(
      (axis) => corners.reduce((sum, v) => sum + cells.positions[v * 3 + axis], 0) / Math.max(corners.length, 1),
    );
    for (const facet of cells.facets[cell]) {
      const first = owner.length;
      facet.forEach((v, i) => {
        positions.push(...cells.positions.subarray(v * 3, v * 3 + 3));
        owner.push(cell);
        middles.push(...middle);
        edges.push(first + i, first + ((i + 1) % facet.length));
      });
      // Facets are convex.
      for (let i = 1; i + 1 < facet.length; i += 1) {
        triangles.push(first, first + i, first + i + 1);
      }
    }
  }
  return {
    positions: new Float32Array(positions),
    middles: new Float32Array(middles),
    owner,
    triangles: new Uint32Array(triangles),
    edges,
  };
}

/** Moves each cell away from the middle of the floor by a share of its distance from there. */
export function explode({ positions, middles }, out, apart, floor) {
  for (let i = 0; i < positions.length; i += 1) {
    out[i] = positions[i] + apart * (middles[i] - (i % 3 === 2 ? floor : 0));
  }
}
