'use strict';
// Where the panels are, and what the browser remembers of it.

/** Kept in the browser, or for this visit only where it keeps nothing. */
const remembered = {large: '', colour: 1, accumulate: 1, size: 2, opacity: 0.8, arrows: true, left: 55, top: 54};
try { Object.assign(remembered, JSON.parse(localStorage.getItem('infuse.view') ?? '{}')); } catch { /* as above */ }
function remember(values) {
  Object.assign(remembered, values);
  try { localStorage.setItem('infuse.view', JSON.stringify(remembered)); } catch { /* as above */ }
}

const onOneScreen = matchMedia('(min-width:1100px)');

class Layout {
  /** `changed` is called when other panels are seen. */
  constructor(changed) {
    this.changed = changed;
    this.main = document.querySelector('main');
    this.sections = [...document.querySelectorAll('section')];
    for (const button of document.querySelectorAll('nav button[data-panel]')) button.addEventListener('click', () => this.open(button.dataset.panel));
    for (const button of document.querySelectorAll('.enlarge')) {
      button.addEventListener('click', () => this.enlarge(remembered.large ? '' : button.closest('section').id));
    }
    document.getElementById('whole').addEventListener('click', () => this.enlarge(''));
    this.main.addEventListener('scroll', () => { clearTimeout(this.settled); this.settled = setTimeout(() => this.update(), 120); });
    onOneScreen.addEventListener('change', () => this.update());
    this.divide();
    this.enlarge(this.sections.some(s => s.id === remembered.large) ? remembered.large : '');
  }

  /** Whether a panel is seen. */
  seen(name) {
    if (onOneScreen.matches) return remembered.large ? remembered.large === name : name !== 'health';
    const section = document.getElementById(name);
    return Math.abs(section.offsetLeft - this.main.offsetLeft - this.main.scrollLeft) < 0.6 * this.main.clientWidth;
  }

  open(name) {
    if (onOneScreen.matches) return this.enlarge(remembered.large === name ? '' : name);
    this.main.scrollTo({left: document.getElementById(name).offsetLeft - this.main.offsetLeft, behavior: 'instant'});
    this.update();
  }

  /** Shows one panel alone; '': all. */
  enlarge(name) {
    remember({large: name});
    this.main.classList.toggle('large', name !== '');
    for (const section of this.sections) section.classList.toggle('large', section.id === name);
    document.getElementById('whole').hidden = name === '';
    this.update();
  }

  update() {
    for (const button of document.querySelectorAll('nav button[data-panel]')) {
      const current = onOneScreen.matches ? remembered.large === button.dataset.panel : this.seen(button.dataset.panel);
      button.setAttribute('aria-current', String(current));
    }
    this.changed();
  }

  /** The corner between the panels can be dragged. */
  divide() {
    const gutter = document.getElementById('gutter-columns');
    const apply = () => {
      this.main.style.setProperty('--left', `${remembered.left}%`);
      this.main.style.setProperty('--top', `${remembered.top}%`);
    };
    gutter.addEventListener('pointerdown', e => gutter.setPointerCapture(e.pointerId));
    gutter.addEventListener('pointermove', e => {
      if (!gutter.hasPointerCapture(e.pointerId)) return;
      const box = this.main.getBoundingClientRect(), share = (v, low, size) => Math.min(80, Math.max(20, 100 * (v - low) / size));
      remember({left: share(e.clientX, box.left, box.width), top: share(e.clientY, box.top, box.height)});
      apply();
    });
    gutter.addEventListener('dblclick', () => { remember({left: 55, top: 54}); apply(); });
    apply();
  }
}
