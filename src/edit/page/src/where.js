// Where an edit is: the places that its action names.

/** The places of the scene that an action of a building names. */
export function placesOf(action, { frame, floor }) {
  const [[name, told]] = Object.entries(action);
  const flat = (places) => places.map((place) => frame.planToScene(place, floor));
  const scene = (places) => places.map((place) => frame.toScene(place));
  const ofRegion = ({ near, box, polygon }) =>
    near ? scene(near.places) : box ? scene([box.min, box.max]) : flat(polygon.ring);
  switch (name) {
    case 'switch-plane':
    case 'align-plane':
    case 'move-plane':
      return scene(told.plane.extent);
    case 'add-plane':
      return scene(told.places);
    case 'mark-place':
      return scene([told.place]);
    case 'exclude-points':
      return ofRegion(told.region);
    case 'redraw-footprint':
      return flat(told.polygons.flat(2));
    case 'offset-edge':
      return flat(told.edge);
    case 'split-parts':
      return flat(told.line);
    default:
      return [];
  }
}
