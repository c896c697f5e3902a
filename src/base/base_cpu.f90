!> Instruction set of the processor.
module base_cpu
  implicit none
  private
  public :: vector_level

  character(8), parameter :: LEVEL_3(7) = &
                             ['avx2    ', 'bmi1    ', 'bmi2    ', 'f16c    ', 'fma     ', &
                              'abm     ', 'movbe   ']
  character(8), parameter :: LEVEL_4(5) = &
                             ['avx512f ', 'avx512bw', 'avx512cd', 'avx512dq', 'avx512vl']

contains

  !> Level of the x86-64 instruction set, as defined by the x86-64 ABI: 4 (AVX-512), 3 (AVX2 and
  !! FMA) or 1 (any other processor, or a system without /proc).
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
      if (.not. has(line, LEVEL_3)) exit
      level = merge(4, 3, has(line, LEVEL_4))
      exit
    end do
    close (unit)
  end function vector_level

  !> Does the line contain all the words?
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
