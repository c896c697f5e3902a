!> What the processor can do.
module base_cpu
  implicit none
  private
  public :: vector_level

contains

  !> Level of the x86-64 instruction set: 4 (AVX-512), 3 (AVX2 and FMA), 1 (any; other processors too).
  !! The names are those of the kernel's list, the levels those of the x86-64 psABI.
  function vector_level() result(level)
    integer :: level

    integer, parameter :: LONGEST = 8192
    character(LONGEST) :: line
    integer :: unit, status

    level = 1
    open (newunit=unit, file='/proc/cpuinfo', status='old', action='read', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (line(:5) /= 'flags') cycle
      if (has(line, [character(8) :: 'avx2', 'bmi1', 'bmi2', 'f16c', 'fma', 'abm', 'movbe'])) level = 3
      if (level == 3 .and. has(line, [character(8) :: 'avx512f', 'avx512bw', 'avx512cd', 'avx512dq', &
        'avx512vl'])) level = 4
      exit
    end do
    close (unit)
  end function vector_level

  !> All the words stand in the line.
  pure function has(line, words) result(found)
    character(*), intent(in) :: line, words(:)
    logical :: found

    integer :: i

    found = .true.
    do i = 1, size(words)
      found = found .and. index(' '//trim(line)//' ', ' '//trim(words(i))//' ') > 0
    end do
  end function has

end module base_cpu
