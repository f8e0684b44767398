// Dark or light.

/** As the system is, until the button is pressed; `state` is told. */
export function makeTheme(state, button, asked) {
  const system = window.matchMedia('(prefers-color-scheme: dark)');
  let chosen = asked;
  const apply = () => {
    const theme = chosen ?? (system.matches ? 'dark' : 'light');
    document.documentElement.dataset.theme = theme;
    state.set({ theme });
  };
  const toggle = () => {
    chosen = state.theme === 'dark' ? 'light' : 'dark';
    apply();
  };
  system.addEventListener('change', apply);
  button.addEventListener('click', toggle);
  apply();
  return { toggle, chosen: () => chosen, choose: (theme) => ((chosen = theme), apply()) };
}
