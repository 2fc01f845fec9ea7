// A '?' that opens an explanation beside it: by a finger as well as by a mouse or a key.

interface WhyProps {
  about: string;
  open: boolean;
  testid: string;
  set(open: boolean): void;
}

export function Why({ about, open, testid, set }: WhyProps) {
  return (
    <button
      type="button"
      class="why"
      aria-expanded={open}
      aria-label={`${about}: explanation`}
      data-testid={testid}
      onClick={() => set(!open)}>
      ?
    </button>
  );
}
