// The hands of a session, a line each: its colour, its name, the norm of its force, and a way to see its ticks.
import { byId } from './dom.js';

/// All hands by name, in an order that does not depend on whose view it is. others: of a frame.
export const hand_names = (own, others) => [own, ...others.map(({ name }) => name)].sort();

/// SESSION and HAND of SESSION+HAND.
export function parts_of(session) {
  const [whole, hand = ''] = session.split('+');
  return { whole, hand };
}

function make_line(name, index, own, choose) {
  const line = document.createElement('div');
  const swatch = document.createElement('i');
  swatch.className = `hand hand-${index % 4}`;
  const label = document.createElement('b');
  label.textContent = name;
  const force = document.createElement('span');
  force.id = `hand-force-${name}`;
  line.append(swatch, label, force);
  if (name === own) {
    line.append('plotted below');
  } else {
    const button = document.createElement('button');
    button.textContent = 'Plot';
    button.setAttribute('aria-label', `Plot hand ${name}`);
    button.addEventListener('click', () => choose(name));
    line.append(button);
  }
  return line;
}

/// choose(name): the user wants the plots of that hand.
export function show_hands(frame, own, choose) {
  const others = frame.others ?? [];
  const names = others.length ? hand_names(own, others) : [];
  const hands = byId('hands');
  const known = `${own} of ${names.join()}`;
  if (hands.dataset.known !== known) {
    hands.dataset.known = known;
    hands.replaceChildren(...names.map((name, index) => make_line(name, index, own, choose)));
  }
  for (const { name, tool } of [...others, { name: own, tool: frame.tool }]) {
    if (!names.includes(name)) continue;
    const force_N = tool ? Math.hypot(...tool.force_N).toFixed(2) : '–';
    byId(`hand-force-${name}`).textContent = `${force_N} N`;
  }
}
