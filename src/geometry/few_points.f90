!> Warnings about QUADrature with fewer integration points than the elements of a body need. Such
!! elements can deform without any strain at their points (hourglass modes).
!!
!! Lagrange functions need degree + 1 points in each direction. Splines share functions between
!! elements and can need fewer. In one direction, the values at the points determine a spline if
!! there are at least as many points as functions; the number of functions that exceeds the number
!! of points is the shortage of this direction. Ranks of patches of 1 to 4 elements in each
!! direction, with degrees 1 to 3 and 1 to 4 points, show that there are hourglass modes if the sum
!! of the shortages of all directions is at least 2 (for instance 27 modes for one quadratic element
!! with 2 x 2 x 2 points, but none for two elements in each direction), or if there is only one
!! point in a direction.
module few_points
  use base_log, only: warn
  use base_text, only: quoted, to_text
  use patch_spec, only: patch_spec_t
  implicit none
  private
  public :: warn_few_points, splines_lack_points

contains

  !> Have splines fewer integration points than they need?
  pure logical function splines_lack_points(points, functions, elements) result(lack)
    integer, intent(in) :: points(:)    !! (nd) points of an element in each direction
    integer, intent(in) :: functions(:) !! (nd) functions of the patch in each direction
    integer, intent(in) :: elements(:)  !! (nd) elements of the patch in each direction
    integer :: shortage(size(points))

    shortage = max(0, functions - points*elements)
    lack = sum(shortage) > 1 .or. any(shortage > 0 .and. points == 1)
  end function splines_lack_points

  !> Warn that the elements `name` of a body have too few integration points.
  subroutine warn_few_points(spec, name, enough)
    type(patch_spec_t), intent(in) :: spec
    character(*), intent(in) :: name
    character(*), intent(in) :: enough  !! numbers of points that suffice
    character(:), allocatable :: text

    text = 'QUADrature '//to_text(spec%q)
    if (spec%qz > 0) text = text//' '//to_text(spec%qz)
    call warn(text//' has too few integration points for '//trim(name)//' elements of ' &
              //quoted(spec%name)//': they can deform without strain energy (hourglass modes), ' &
              //'and their stresses may be meaningless', spec%place, 'use '//enough//', or omit ' &
              //'QUADrature')
  end subroutine warn_few_points

end module few_points
