// Which wire does what a person wants, by the makers' tables and the model. It needs no servo and writes nothing.

import { CourseCard } from './course_card';
import { found, selected } from './found';
import { OthersCard, WiresCard } from './wires_card';
import { WishForm } from './wish_form';

export function ChooseView() {
  const answer = found.value;
  const wire = answer?.wires[selected.value];
  return (
    <div class="choose">
      <WishForm />
      {answer && <WiresCard answer={answer} />}
      {answer && wire && <CourseCard wire={wire} answer={answer} />}
      {answer && answer.others.length > 0 && <OthersCard others={answer.others} />}
    </div>
  );
}
