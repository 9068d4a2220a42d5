// SPDX-License-Identifier: MIT
// The best courses of a roll, by a study: where the first begins, and by how much each next one overlaps.
import { read } from './api.js';
import { element } from './dom.js';
import { format } from './fields.js';
import { numberOf } from './form.js';
import { coursesOf, plyOf, showCourses } from './pieces.js';
import { Search } from './search.js';

const NONE = 'Say the width of the roll, and along what the first course lies.';
const OVERLAP = 0.25; // of the width, where no other most is given
const BUDGET = 200; // for two values
const DIGITS = 6;
const TOLD = {
  waste_area: (value, unit) => `${format(value, 3)} ${unit}² trimmed off`,
  max_shear_deg: (value) => `shear up to ${format(value, 3)}°`,
};

const rounded = (values) => [values].flat(2).map((value) => Number(value.toPrecision(DIGITS)));

export class Coursing {
  /** `onTake()` when courses that were found are in the form. */
  constructor(form, { onTake, onError }) {
    Object.assign(this, { form, onTake });
    this.search = new Search({
      button: 'course-search',
      state: 'course-search-state',
      study: () => this.#study(),
      onFound: (result, id) => this.#show(result, id),
      onError,
    });
    element('course-take').addEventListener('click', () => this.#take());
    this.clear();
  }

  /** Another part, or nothing of it is wanted. */
  clear() {
    this.search.stop();
    this.search.say('');
    this.#offer(null);
  }

  #offer(courses) {
    this.found = courses;
    element('course-take').hidden = !courses;
  }

  #study() {
    this.#offer(null);
    this.form.check();
    const courses = coursesOf();
    if (!courses) throw new Error(NONE);
    const { surfaceText, unit, rosette } = this.form;
    const ply = {
      ...plyOf(this.form.settings(), { courses }),
      name: undefined,
      courses: undefined,
    };
    const drape = JSON.stringify({ length_unit: unit, rosette, ...ply });
    const narrow = Math.min(...[courses.width].flat());
    const most = numberOf(element('course-most').value);
    const study = {
      courses,
      vary: {
        courses: {
          first_offset: { from: -narrow / 2, to: 0 },
          offsets: { from: -(Number.isFinite(most) ? most : OVERLAP * narrow), to: 0 },
        },
      },
      objectives: [element('course-aim').value],
      budget: BUDGET,
    };
    this.asked = courses;
    return `{"drape":{"surface":${surfaceText},${drape.slice(1)},${JSON.stringify(study).slice(1)}`;
  }

  /** The best courses, as the form has them. */
  async #show({ best, variants, summary }, id) {
    const [[aim, row]] = Object.entries(best);
    if (!(row >= 0)) return summary.verdict.detail;
    const { plies } = await read(`v1/studies/${id}/variants/${row}/request`);
    const { first_offset, gap } = plies[0].courses;
    const { gap: _gap, overlap: _overlap, ...kept } = this.asked;
    this.#offer({ ...kept, first_offset: rounded(first_offset ?? 0), gap: rounded(gap ?? 0) });
    const told = (variant) => TOLD[aim](variants[aim][variant], this.form.unit);
    const covered = format(100 * variants.cloth_coverage[row], 4);
    return `${told(row)}, ${covered} % covered; as it was ${told(0)}.`;
  }

  #take() {
    showCourses(this.found);
    this.clear();
    this.onTake();
  }
}
