// All colours, for dark and for light surroundings: one table for the page (CSS), the plots and the picture.
// Series that share a plot differ for who sees no red, no green or no blue too (logic_test measures it), and
// those of one plot by their dashes besides.

export const kThemes = {
  dark: {
    css: {
      ground: '#0e1216', panel: '#151a20', card: '#1b2129', line: '#2b3440', text: '#d7dee6', muted: '#97a3b0',
      button: '#212933', 'button-line': '#4a5664', hover: '#2b3541', on: '#1d4f77', accent: '#5aa9e6',
      alive: '#2f9e6b', 'alive-text': '#04140c', dead: '#c4282f', 'dead-text': '#ffffff', neutral: '#39424d',
      'neutral-text': '#ffffff',
    },
    plot: {
      grid: '#232a33', strip: '#1d232b', text: '#d7dee6', muted: '#97a3b0', cursor: '#9aa7b4',
      norm: '#fee440', x: '#ef4250', y: '#62f6dc', z: '#6f7adc', age: '#c792ea', mark: '#e3e9ef',
      work: '#4fc1b0', wake: '#e79a4b', flag: '#e5644a',
    },
    picture: {
      ground: '#0e1216', plane: '#2a323c', grid: '#3d4855', fine_grid: '#323b46', sky: '#dfe9f5', earth: '#39404a',
      tool: '#eef2f6', stem: '#aab3bd', label: '#ffffff', label_ground: '#0e1216',
      newest: '#57c7ff', previous: '#ff9d5c', path: '#8cbff2',
      hands: ['#fedb34', '#4776f5', '#c65b97', '#4ff599'],
    },
  },
  light: {
    css: {
      ground: '#e9edf1', panel: '#ffffff', card: '#eff2f5', line: '#c9d1d9', text: '#17202a', muted: '#505d6b',
      button: '#ffffff', 'button-line': '#8894a1', hover: '#e6ebf0', on: '#cfe4f6', accent: '#1667a8',
      alive: '#1d7a4f', 'alive-text': '#ffffff', dead: '#b71c24', 'dead-text': '#ffffff', neutral: '#56626f',
      'neutral-text': '#ffffff',
    },
    plot: {
      grid: '#dfe4e9', strip: '#eff2f5', text: '#17202a', muted: '#505d6b', cursor: '#5b6875',
      norm: '#0a0e12', x: '#c0520d', y: '#048767', z: '#2a34d0', age: '#7d3fb2', mark: '#3a4450',
      work: '#0b7a6c', wake: '#b05a00', flag: '#c43b1f',
    },
    picture: {
      ground: '#e9edf1', plane: '#cfd7df', grid: '#a3aeba', fine_grid: '#bcc5cf', sky: '#ffffff', earth: '#9aa5b1',
      tool: '#fbfcfd', stem: '#7a8692', label: '#10161c', label_ground: '#ffffff',
      newest: '#0077b6', previous: '#c25100', path: '#1667a8',
      hands: ['#885c06', '#4a75e7', '#d0146f', '#133a25'],
    },
  },
};

/// Of the bodies, in both themes: hues far apart; a further round is darker (palette.js).
export const kBodyColours = ['#386d93', '#34c27c', '#9c6443', '#85b5be', '#d76ed4', '#b4c258', '#6a57c8', '#7f887d'];

/// Dashes of a series, in pixels; none: drawn through.
export const kDashes = { x: [], y: [7, 3], z: [2, 3], wake: [6, 3] };

const kKept = 'stillgrid-theme';

function kept_choice() {
  try {
    return localStorage.getItem(kKept);
  } catch {
    return null;  // a browser that keeps nothing
  }
}

/// Which of the two is shown: the system's, until the user chose the other one.
export class Theme {
  /// on_change: called with no argument whenever the colours are others.
  constructor(on_change) {
    this.system = matchMedia('(prefers-color-scheme: light)');
    this.on_change = on_change;
    this.chosen = kept_choice();
    this.system.addEventListener('change', () => this.#apply());
    this.#apply();
  }

  get name() {
    if (this.chosen in kThemes) return this.chosen;
    return this.system.matches ? 'light' : 'dark';
  }

  get colours() { return kThemes[this.name]; }

  /// The other one; what the system wants is followed again, not kept.
  toggle() {
    const other = this.name === 'dark' ? 'light' : 'dark';
    const is_system = other === (this.system.matches ? 'light' : 'dark');
    this.chosen = is_system ? null : other;
    try {
      if (is_system) localStorage.removeItem(kKept);
      else localStorage.setItem(kKept, other);
    } catch { /* then it holds for this page alone */ }
    this.#apply();
  }

  #apply() {
    const root = document.documentElement;
    root.dataset.theme = this.name;
    root.style.colorScheme = this.name;
    for (const [name, colour] of Object.entries(this.colours.css)) root.style.setProperty(`--${name}`, colour);
    for (const [name, colour] of Object.entries(this.colours.picture)) {
      if (typeof colour === 'string') root.style.setProperty(`--picture-${name}`, colour);
    }
    this.colours.picture.hands.forEach((colour, i) => root.style.setProperty(`--hand-${i}`, colour));
    kBodyColours.forEach((colour, i) => root.style.setProperty(`--body-${i}`, colour));
    this.on_change();
  }
}
