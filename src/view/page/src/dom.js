// Elements from data. Text goes in as text, never as HTML: ids and attributes come from files.

/** An element: `properties` are set on it (`class`, `dataset`, `aria-…`, `on…` handlers, others), `children` appended. */
export function element(tag, properties = {}, ...children) {
  const node = document.createElement(tag);
  assign(node, properties);
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

/** The same for SVG. */
export function svg(tag, properties = {}, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  assign(node, properties);
  node.append(...children.flat());
  return node;
}

function assign(node, properties) {
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) {
      continue;
    }
    if (name.startsWith('on')) {
      node.addEventListener(name.slice(2), value);
    } else if (name === 'style') {
      // Property by property: the policy of the page forbids style attributes.
      Object.entries(value).forEach(([key, text]) => node.style.setProperty(key, text));
    } else {
      node.setAttribute(name, value === true ? '' : String(value));
    }
  }
}

/** The element of this id, which the page has. */
export const byId = (id) => document.getElementById(id);

/** Says in the place of the page why there is none of `what`. */
export function showFailure(error, what) {
  const node = byId('loading');
  node.hidden = false;
  node.classList.add('failed');
  const isGraphics = /webgl/i.test(String(error));
  refill(
    node,
    isGraphics
      ? 'This browser cannot draw in 3D: WebGL 2 is switched off or not there.'
      : `The ${what} cannot be shown: ${error.message}`,
  );
  console.error(error);
}

/** Puts other children into an element. */
export function refill(node, ...children) {
  node.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined));
}
